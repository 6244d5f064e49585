#include "deformable_sim/core/material/bending_law.h"

#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/sheet_law.h"

namespace deformable_sim {

BendingMaterial isotropic_bending(double rigidity, double poissons_ratio) {
  BendingMaterial material;
  material.warp = material.weft = rigidity;
  material.poissons_ratio = poissons_ratio;
  check_material(material);
  return material;
}

void check_material(const BendingMaterial& material) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw InputError(std::string(name) + " rigidity is " + std::to_string(value) + " N m; it must be finite and > 0");
    }
  };
  positive("warp", material.warp);
  positive("weft", material.weft);
  if (material.twist) positive("twist", *material.twist);
  const double nu = material.poissons_ratio;
  if (!(std::abs(nu) < 1.0) || !(nu * nu * material.weft < material.warp)) {
    throw InputError("Poisson's ratio of bending is " + std::to_string(nu) +
                     "; |nu| < 1 and nu^2 weft / warp < 1 are needed");
  }
  if (!(material.damping >= 0.0) || !std::isfinite(material.damping)) {
    throw InputError("damping of bending is " + std::to_string(material.damping) + " s; it must be finite and >= 0");
  }
  check_direction(material.warp_direction);
  for (const Crease& crease : material.creases) {
    if (!(std::abs(crease.angle) < M_PI)) {
      throw InputError("a crease has an angle of " + std::to_string(crease.angle) +
                       " rad; it must lie between -pi and pi");
    }
  }
}

Mat3 plate_stiffness(const BendingMaterial& material) {
  const double ratio = material.weft / material.warp, nu = material.poissons_ratio;
  const double along = material.warp / (1.0 - nu * nu * ratio), across = along * ratio;
  const double twist = material.twist.value_or(0.5 * (std::sqrt(along * across) - nu * across));
  Mat3 d;
  d << along, nu * across, 0.0, nu * across, across, 0.0, 0.0, 0.0, twist;
  return d;
}

}  // namespace deformable_sim
