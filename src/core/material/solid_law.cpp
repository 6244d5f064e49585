// Energies of isotropic solids by principal stretches, and their first and second derivatives.
#include "deformable_sim/core/material/solid_law.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

const std::array<const char*, 6> kNames = {"hooke",       "corotational",       "st_venant_kirchhoff",
                                           "neo_hookean", "stable_neo_hookean", "mooney_rivlin"};

/// d J / d s_i: the product of the other two.
Vec3 others(const Vec3& s) {
  return Vec3(s[1] * s[2], s[2] * s[0], s[0] * s[1]);
}

double undefined(Vec3* gradient, Mat3* hessian) {
  gradient->setConstant(kNoNumber);
  if (hessian != nullptr) hessian->setConstant(kNoNumber);
  return kInfinity;
}

double corotational(const SolidMaterial& m, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  const Vec3 e = s.array() - 1.0;
  const double trace = e.sum();
  *gradient = (2.0 * m.mu * e).array() + m.lambda * trace;
  if (hessian != nullptr) {
    hessian->setConstant(m.lambda);
    hessian->diagonal().array() += 2.0 * m.mu;
  }
  return m.mu * e.squaredNorm() + 0.5 * m.lambda * trace * trace;
}

double st_venant_kirchhoff(const SolidMaterial& m, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  const Vec3 e = 0.5 * (s.array().square() - 1.0);
  const double trace = e.sum();
  const Vec3 stress = (2.0 * m.mu * e).array() + m.lambda * trace;
  *gradient = s.cwiseProduct(stress);
  if (hessian != nullptr) {
    *hessian = m.lambda * s * s.transpose();
    hessian->diagonal() += stress + 2.0 * m.mu * s.cwiseAbs2();
  }
  return m.mu * e.squaredNorm() + 0.5 * m.lambda * trace * trace;
}

double neo_hookean(const SolidMaterial& m, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  const double j = s.prod();
  if (!(j > 0.0)) return undefined(gradient, hessian);
  const double log_j = std::log(j), c = m.lambda * log_j - m.mu;
  const Vec3 inverse = s.cwiseInverse();
  *gradient = m.mu * s + c * inverse;
  if (hessian != nullptr) {
    *hessian = m.lambda * inverse * inverse.transpose();
    hessian->diagonal().array() += m.mu - c * inverse.array().square();
  }
  return 0.5 * m.mu * (s.squaredNorm() - 3.0) - m.mu * log_j + 0.5 * m.lambda * log_j * log_j;
}

/// The parameters that make the linearised law Hooke's [Smith 2018, section 3.4].
struct Stable {
  explicit Stable(const SolidMaterial& material)
      : m(4.0 / 3.0 * material.mu), l(material.lambda + 5.0 / 6.0 * material.mu), a(1.0 + 0.75 * m / l) {}
  double m, l, a;
};

double stable_neo_hookean(const SolidMaterial& material, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  const Stable p(material);
  const double i1 = s.squaredNorm(), j = s.prod(), pressure = p.l * (j - p.a);
  const double shear = p.m * (1.0 - 1.0 / (i1 + 1.0));
  const Vec3 area = others(s);
  *gradient = shear * s + pressure * area;
  if (hessian != nullptr) {
    *hessian = (2.0 * p.m / ((i1 + 1.0) * (i1 + 1.0))) * s * s.transpose() + p.l * area * area.transpose();
    hessian->diagonal().array() += shear;
    for (int k = 0; k < 3; ++k) {
      (*hessian)((k + 1) % 3, (k + 2) % 3) += pressure * s[k];
      (*hessian)((k + 2) % 3, (k + 1) % 3) += pressure * s[k];
    }
  }
  const double at_rest = 0.5 * p.l * (1.0 - p.a) * (1.0 - p.a);
  return 0.5 * p.m * (i1 - 3.0 - std::log((i1 + 1.0) / 4.0)) + 0.5 * p.l * (j - p.a) * (j - p.a) - at_rest;
}

/// W = c10 J^(-2/3) I1 + c01 J^(-4/3) I2 + U(J) seen as a function of I1, I2 and J.
struct Mooney {
  Mooney(const SolidMaterial& m, const Vec3& s)
      : j(s.prod()), i1(s.squaredNorm()), i2(others(s).squaredNorm()), bulk(m.lambda + 2.0 / 3.0 * m.mu) {
    const double c10 = 0.5 * m.share * m.mu, c01 = 0.5 * (1.0 - m.share) * m.mu, root = std::cbrt(j);
    w1 = c10 / (root * root);
    w2 = c01 / (j * root);
    energy = w1 * i1 - 3.0 * c10 + w2 * i2 - 3.0 * c01 + 0.5 * bulk * (j - 1.0) * (j - 1.0);
    w_j = bulk * (j - 1.0) - (2.0 / 3.0 * w1 * i1 + 4.0 / 3.0 * w2 * i2) / j;
    w_jj = bulk + (10.0 / 9.0 * w1 * i1 + 28.0 / 9.0 * w2 * i2) / (j * j);
  }
  double j, i1, i2, bulk;
  double w1, w2;  // dW/dI1, dW/dI2
  double energy, w_j, w_jj;
};

double mooney_rivlin(const SolidMaterial& m, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  if (!(s.prod() > 0.0)) return undefined(gradient, hessian);
  const Mooney w(m, s);
  const Vec3 area = others(s);
  const Vec3 i2_gradient = 2.0 * s.array() * (w.i1 - s.array().square());
  *gradient = 2.0 * w.w1 * s + w.w2 * i2_gradient + w.w_j * area;
  if (hessian != nullptr) {
    // d(dW/dI1)/dJ and d(dW/dI2)/dJ couple the invariants.
    const Vec3 mixed = (-4.0 / 3.0 * w.w1 / w.j) * s + (-4.0 / 3.0 * w.w2 / w.j) * i2_gradient;
    *hessian = w.w_jj * area * area.transpose() + mixed * area.transpose() + area * mixed.transpose();
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, n = (k + 2) % 3;
      const double pair = 4.0 * w.w2 * s[i] * s[n] + w.w_j * s[k];
      (*hessian)(i, n) += pair;
      (*hessian)(n, i) += pair;
      (*hessian)(k, k) += 2.0 * w.w1 + 2.0 * w.w2 * (w.i1 - s[k] * s[k]);
    }
  }
  return w.energy;
}

}  // namespace

std::vector<std::string> solid_law_names() {
  return {kNames.begin(), kNames.end()};
}

SolidLaw solid_law(const std::string& name) {
  for (size_t k = 0; k < kNames.size(); ++k) {
    if (name == kNames[k]) return static_cast<SolidLaw>(k);
  }
  std::string names;
  for (const char* known : kNames) names += (names.empty() ? "" : ", ") + std::string(known);
  throw InputError("no solid law is called \"" + name + "\"; known are " + names, Code::kNotFound);
}

SolidMaterial solid_material(SolidLaw law, double youngs_modulus, double poissons_ratio) {
  if (!(youngs_modulus > 0.0) || !std::isfinite(youngs_modulus)) {
    throw InputError("Young's modulus is " + std::to_string(youngs_modulus) + " Pa; it must be finite and > 0");
  }
  if (!(poissons_ratio > -1.0 && poissons_ratio < 0.5)) {
    throw InputError("Poisson's ratio is " + std::to_string(poissons_ratio) + "; it must be > -1 and < 0.5");
  }
  if (law == SolidLaw::kNeoHookean && poissons_ratio < 0.0) {
    throw InputError(
        "Poisson's ratio is " + std::to_string(poissons_ratio) +
        "; neo_hookean needs 0 or more: below, its energy falls without bound when it is pressed together");
  }
  SolidMaterial material;
  material.law = law;
  material.mu = youngs_modulus / (2.0 * (1.0 + poissons_ratio));
  material.lambda = youngs_modulus * poissons_ratio / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio));
  return material;
}

double energy_density(const SolidMaterial& material, const Vec3& s, Vec3* gradient, Mat3* hessian) {
  switch (material.law) {
    case SolidLaw::kHooke:
      break;
    case SolidLaw::kCorotational:
      return corotational(material, s, gradient, hessian);
    case SolidLaw::kStVenantKirchhoff:
      return st_venant_kirchhoff(material, s, gradient, hessian);
    case SolidLaw::kNeoHookean:
      return neo_hookean(material, s, gradient, hessian);
    case SolidLaw::kStableNeoHookean:
      return stable_neo_hookean(material, s, gradient, hessian);
    case SolidLaw::kMooneyRivlin:
      return mooney_rivlin(material, s, gradient, hessian);
  }
  assert(false && "Hooke's linear law is no function of the stretches");
  return undefined(gradient, hessian);
}

void pair_moduli(const SolidMaterial& material, const Vec3& s, Vec3* twist, Vec3* flip) {
  const double mu = material.mu, lambda = material.lambda;
  const Vec3 product = others(s), square = s.cwiseAbs2();
  switch (material.law) {
    case SolidLaw::kHooke:  // as seen from the fixed axes: the antisymmetric part of F costs nothing
      twist->setZero();
      flip->setConstant(2.0 * mu);
      return;
    case SolidLaw::kCorotational: {
      const double rotating = 2.0 * lambda * (s.sum() - 3.0) - 4.0 * mu;
      for (int k = 0; k < 3; ++k) (*twist)[k] = 2.0 * mu + rotating / std::max(s.sum() - s[k], 1e-6);
      flip->setConstant(2.0 * mu);
      return;
    }
    case SolidLaw::kStVenantKirchhoff: {
      const double base = 0.5 * lambda * (square.sum() - 3.0) - mu;
      const Vec3 pair = (base + mu * (square.sum() - square.array())).matrix();
      *twist = pair - mu * product;
      *flip = pair + mu * product;
      return;
    }
    case SolidLaw::kNeoHookean: {
      const double j = s.prod();
      const double c = j > 0.0 ? lambda * std::log(j) - mu : kNoNumber;
      *twist = mu + c * product.array().inverse();
      *flip = mu - c * product.array().inverse();
      return;
    }
    case SolidLaw::kStableNeoHookean: {
      const Stable p(material);
      const double shear = p.m * (1.0 - 1.0 / (square.sum() + 1.0)), pressure = p.l * (s.prod() - p.a);
      *twist = shear + pressure * s.array();
      *flip = shear - pressure * s.array();
      return;
    }
    case SolidLaw::kMooneyRivlin: {
      const Mooney w(material, s);
      *twist = 2.0 * w.w1 + 2.0 * w.w2 * (square + product).array() + w.w_j * s.array();
      *flip = 2.0 * w.w1 + 2.0 * w.w2 * (square - product).array() - w.w_j * s.array();
      return;
    }
  }
}

}  // namespace deformable_sim
