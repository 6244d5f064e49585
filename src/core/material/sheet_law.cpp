#include "deformable_sim/core/material/sheet_law.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

bool any_stiffness_allowed(SolidLaw law) {
  return law == SolidLaw::kStVenantKirchhoff || law == SolidLaw::kHooke;
}

/// psi, dpsi/dt and d2psi/dt2 at thickness stretch t.
struct Across {
  double energy = 0.0;
  Vec3 gradient = Vec3::Zero();
  Mat3 hessian = Mat3::Zero();
};

Across across(const SolidMaterial& material, const Eigen::Vector2d& s, double t) {
  Across at;
  at.energy = energy_density(material, Vec3(s[0], s[1], t), &at.gradient, &at.hessian);
  return at;
}

/// Newton's method on dpsi/dt = 0, kept inside a bracket that the sign of dpsi/dt narrows.
Across without_normal_stress(const SolidMaterial& material, const Eigen::Vector2d& s) {
  const double ratio = material.lambda / (material.lambda + 2.0 * material.mu);
  double low = 0.0, high = std::numeric_limits<double>::infinity();
  // Small strains: log t = -ratio (log s1 + log s2).
  double t = std::pow(std::max(s[0] * s[1], 1e-12), -ratio);
  Across at = across(material, s, t);
  for (int k = 0; k < 100; ++k) {
    (at.gradient[2] > 0.0 ? high : low) = t;
    double next = t - at.gradient[2] / at.hessian(2, 2);
    if (!(at.hessian(2, 2) > 0.0) || !(next > low) || !(next < high)) {
      next = std::isfinite(high) ? 0.5 * (low + high) : 2.0 * t;
    }
    if (std::abs(next - t) <= 1e-15 * t) break;
    t = next;
    at = across(material, s, t);
  }
  return at;
}

/// mu |s - 1|^2 + lambda' / 2 (s1 + s2 - 2)^2.
double corotational(double mu, double lambda, const Eigen::Vector2d& s, Eigen::Vector2d* gradient,
                    Eigen::Matrix2d* hessian) {
  const Eigen::Vector2d strain = s.array() - 1.0;
  *gradient = 2.0 * mu * strain + Eigen::Vector2d::Constant(lambda * strain.sum());
  if (hessian != nullptr) {
    *hessian = 2.0 * mu * Eigen::Matrix2d::Identity() + Eigen::Matrix2d::Constant(lambda);
  }
  return mu * strain.squaredNorm() + 0.5 * lambda * strain.sum() * strain.sum();
}

/// mu |E|^2 + lambda' / 2 (tr E)^2, E = (s^2 - 1) / 2.
double st_venant_kirchhoff(double mu, double lambda, const Eigen::Vector2d& s, Eigen::Vector2d* gradient,
                           Eigen::Matrix2d* hessian) {
  const Eigen::Vector2d green = 0.5 * (s.array().square() - 1.0);
  const Eigen::Vector2d stress = 2.0 * mu * green + Eigen::Vector2d::Constant(lambda * green.sum());
  *gradient = s.cwiseProduct(stress);
  if (hessian != nullptr) {
    *hessian = lambda * s * s.transpose();
    hessian->diagonal() += 2.0 * mu * s.cwiseAbs2() + stress;
  }
  return mu * green.squaredNorm() + 0.5 * lambda * green.sum() * green.sum();
}

std::string text(double value) {
  return std::to_string(value);
}

}  // namespace

SheetMaterial isotropic_sheet(SolidLaw law, double membrane, double poissons_ratio) {
  SheetMaterial material;
  material.law = law;
  material.warp = material.weft = membrane;
  material.poissons_ratio = poissons_ratio;
  material.shear = membrane / (2.0 * (1.0 + poissons_ratio));
  check_material(material);
  return material;
}

void check_material(const SheetMaterial& material) {
  const auto positive = [](const char* name, double value) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw InputError(std::string(name) + " stiffness is " + text(value) + " N/m; it must be finite and > 0");
    }
  };
  positive("warp", material.warp);
  positive("weft", material.weft);
  positive("shear", material.shear);
  const double nu = material.poissons_ratio;
  if (!(std::abs(nu) < 1.0) || !(nu * nu * material.weft < material.warp)) {
    throw InputError("Poisson's ratio is " + text(nu) + "; |nu| < 1 and nu^2 weft / warp < 1 are needed");
  }
  if (!(material.damping >= 0.0) || !std::isfinite(material.damping)) {
    throw InputError("damping is " + text(material.damping) + " s; it must be finite and >= 0");
  }
  if (!(material.thickness >= 0.0)) {
    throw InputError("thickness is " + text(material.thickness) + " m; it must be >= 0");
  }
  check_direction(material.warp_direction);
  if (any_stiffness_allowed(material.law)) return;
  const double shear = 0.5 * material.warp / (1.0 + nu);
  if (std::abs(material.weft - material.warp) > 1e-9 * material.warp ||
      std::abs(material.shear - shear) > 1e-9 * shear) {
    throw InputError("this law is isotropic: weft must equal warp (" + text(material.warp) +
                     " N/m) and shear warp / (2 (1 + nu)) (" + text(shear) +
                     " N/m); st_venant_kirchhoff and hooke take other values");
  }
  if (!(nu < 0.5)) throw InputError("Poisson's ratio is " + text(nu) + "; this law needs nu < 0.5");
  if (material.law == SolidLaw::kMooneyRivlin && !(material.share >= 0.0 && material.share <= 1.0)) {
    throw InputError("Mooney-Rivlin share is " + text(material.share) + "; it must lie in [0, 1]");
  }
}

void check_direction(const Vec3& warp_direction) {
  if (warp_direction.allFinite() && warp_direction.norm() > 0.0) return;
  throw InputError("the warp direction is not a direction; it must be finite and not zero");
}

Mat3 plane_stiffness(const SheetMaterial& material) {
  const double ratio = material.weft / material.warp, nu = material.poissons_ratio;
  const double along = material.warp / (1.0 - nu * nu * ratio), across = along * ratio;
  Mat3 c;
  c << along, nu * across, 0.0, nu * across, across, 0.0, 0.0, 0.0, material.shear;
  return c;
}

double plane_stress_energy(const SolidMaterial& material, const Eigen::Vector2d& s, Eigen::Vector2d* gradient,
                           Eigen::Matrix2d* hessian) {
  const double mu = material.mu, in_plane = 2.0 * mu * material.lambda / (material.lambda + 2.0 * mu);
  if (material.law == SolidLaw::kCorotational) return corotational(mu, in_plane, s, gradient, hessian);
  if (material.law == SolidLaw::kStVenantKirchhoff) return st_venant_kirchhoff(mu, in_plane, s, gradient, hessian);
  const Across at = without_normal_stress(material, s);
  *gradient = at.gradient.head<2>();
  if (hessian != nullptr) {
    const Eigen::Vector2d coupling = at.hessian.topRightCorner<2, 1>();
    *hessian = at.hessian.topLeftCorner<2, 2>() - coupling * coupling.transpose() / at.hessian(2, 2);
  }
  return at.energy;
}

Vec3 direction_that_matters(const Mat3& stiffness, const Vec3& warp_direction) {
  const double small = 1e-9 * stiffness(0, 0);
  const bool isotropic = std::abs(stiffness(0, 0) - stiffness(1, 1)) < small &&
                         std::abs(0.5 * (stiffness(0, 0) - stiffness(0, 1)) - stiffness(2, 2)) < small;
  return isotropic ? Vec3(Vec3::Zero()) : warp_direction;
}

SolidMaterial solid_of(const SheetMaterial& material) {
  SolidMaterial solid;
  const double nu = material.poissons_ratio;
  solid.law = material.law;
  solid.mu = 0.5 * material.warp / (1.0 + nu);
  solid.lambda = material.warp * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  solid.share = material.share;
  return solid;
}

}  // namespace deformable_sim
