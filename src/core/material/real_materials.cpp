#include "deformable_sim/core/material/real_materials.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kStandardGravity = 9.80665;  // m/s^2
constexpr double kMostCoupling = 0.9;         // of sqrt(warp weft) and of weft

}  // namespace

double FabricData::stable_poisson() const {
  const double most = kMostCoupling * std::min(std::sqrt(warp * weft), weft);
  return std::clamp(poisson, -most, most);
}

double FabricData::traction_bias() const {
  const double c12 = stable_poisson(), determinant = warp * weft - c12 * c12;
  return 4.0 / ((warp + weft - 2.0 * c12) / determinant + 1.0 / shear);
}

std::optional<double> FabricData::bend_twist() const {
  if (!bend_diagonal) return std::nullopt;
  const double compliance = 4.0 / *bend_diagonal - 1.0 / bend_warp - 1.0 / bend_weft;
  if (!(compliance > 0.0)) return std::nullopt;
  return 1.0 / compliance;
}

double FabricData::bending_length() const {
  return std::cbrt(bend_warp / (areal_density * kStandardGravity));
}

double RopeData::wave_speed() const {
  return std::sqrt(axial / linear_density);
}

}  // namespace deformable_sim
