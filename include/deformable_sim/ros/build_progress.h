// Tells in the log that a mesh takes its time.
#pragma once

#include <string>

#include "deformable_sim/core/contact/distance_grid.h"

namespace deformable_sim {

/// Says nothing in the first second, then how much of the distance grid is done, once a second.
DistanceGrid::Progress build_progress(const std::string& what);

}  // namespace deformable_sim
