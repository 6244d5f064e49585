// The air around the bodies: density, drag and wind.
#pragma once

#include "deformable_sim/core/types.h"

namespace deformable_sim {

struct Air {
  double density = 1.2;             // kg/m^3
  double drag_coefficient = 1.0;    // of a flat plate, normal flow
  Vec3 wind = Vec3::Zero();         // m/s
  double gust_amplitude = 0.0;      // fraction of the wind speed
  double gust_frequency = 0.5;      // Hz
  Vec3 wind_at(double time) const;  // wind (1 + amplitude sin(2 pi f t))
};

}  // namespace deformable_sim
