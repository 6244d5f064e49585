// In-plane tests of a sheet: traction, shear, compression, bias extension. No coordinate leaves the plane.
#pragma once

#include "bench.h"
#include "cloth_models.h"

namespace deformable_sim::study {

/// Force per width over strain (N/m) of a strip five times as long as wide, pulled by 0.1 % along warp or weft, and the
/// contraction across it over the extension, in the middle third.
struct Traction {
  int nodes = 0;
  double stiffness = 0.0, ratio = 0.0;
};
enum class Along { kWarp, kWeft };
Traction pull_strip(const FabricData& fabric, const ClothModel& model, Along along, int cells_across);

/// Stress over strain (N/m) of a square whose edge moves affinely: shear by gamma, or compression by epsilon both ways.
Measurement shear_square(const FabricData& fabric, const ClothModel& model, int cells);
Measurement compress_square(const FabricData& fabric, const ClothModel& model, int cells);

/// Stress over strain (N/m) of a square under a uniform stress at 45 degrees to the yarns.
Measurement pull_on_the_bias(const FabricData& fabric, const ClothModel& model, int cells);

}  // namespace deformable_sim::study
