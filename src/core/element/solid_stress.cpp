// Polar decomposition, stresses and tangent moduli of isotropic solids.
#include "deformable_sim/core/element/solid_stress.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace deformable_sim {
namespace {

/// dJ/dF = J F^-T, also where F is singular.
Mat3 cofactor(const Mat3& f) {
  Mat3 c;
  c.col(0) = f.col(1).cross(f.col(2));
  c.col(1) = f.col(2).cross(f.col(0));
  c.col(2) = f.col(0).cross(f.col(1));
  return c;
}

Mat3 hooke(const SolidMaterial& m, const Mat3& f) {
  Mat3 p = m.mu * (f + f.transpose());
  p.diagonal().array() += m.lambda * (f.trace() - 3.0) - 2.0 * m.mu;
  return p;
}

Mat3 corotational(const SolidMaterial& m, const Mat3& f) {
  const Mat3 r = polar_rotation(f);
  return 2.0 * m.mu * (f - r) + (m.lambda * (r.cwiseProduct(f).sum() - 3.0)) * r;
}

Mat3 neo_hookean(const SolidMaterial& m, const Mat3& f) {
  const Mat3 area = cofactor(f);
  const double j = area.col(0).dot(f.col(0));
  if (!(j > 0.0)) return Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  return m.mu * f + ((m.lambda * std::log(j) - m.mu) / j) * area;
}

Mat3 stable_neo_hookean(const SolidMaterial& m, const Mat3& f) {
  const double shear = 4.0 / 3.0 * m.mu, volume = m.lambda + 5.0 / 6.0 * m.mu;
  const Mat3 area = cofactor(f);
  const double j = area.col(0).dot(f.col(0)), i1 = f.squaredNorm();
  return (shear * (1.0 - 1.0 / (i1 + 1.0))) * f + (volume * (j - 1.0) - 0.75 * shear) * area;
}

Mat3 mooney_rivlin(const SolidMaterial& m, const Mat3& f) {
  const Mat3 area = cofactor(f), c = f.transpose() * f;
  const double j = area.col(0).dot(f.col(0));
  if (!(j > 0.0)) return Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  const double c10 = 0.5 * m.share * m.mu, c01 = 0.5 * (1.0 - m.share) * m.mu, bulk = m.lambda + 2.0 / 3.0 * m.mu;
  const double root = std::cbrt(j), w1 = c10 / (root * root), w2 = c01 / (j * root);
  const double i1 = c.trace(), i2 = area.squaredNorm();
  const double w_j = bulk * (j - 1.0) - (2.0 / 3.0 * w1 * i1 + 4.0 / 3.0 * w2 * i2) / j;
  return 2.0 * (w1 + w2 * i1) * f - 2.0 * w2 * f * c + w_j * area;
}

/// Rotation next to F by Newton's iteration R <- (R + R^-T) / 2 on the way to an orthogonal matrix [Higham 1986]; each
/// step doubles the digits. False where that is not the way: far from a rotation, flat or inverted.
bool iterate_rotation(const Mat3& f, Mat3* rotation) {
  const double size = f.squaredNorm();  // 3 for a rotation, whose determinant is 1
  if (!(f.determinant() > 0.01 * size * std::sqrt(size))) return false;
  *rotation = f;
  for (int k = 0; k < 12; ++k) {
    const Mat3 area = cofactor(*rotation);
    const Mat3 next = 0.5 * (*rotation + area / area.col(0).dot(rotation->col(0)));
    const double change = (next - *rotation).squaredNorm();
    *rotation = next;
    if (change < 1e-20) return true;  // the error that is left is of the order of this square
  }
  return false;
}

/// s = q diag(values) q^T of a symmetric matrix by Jacobi's rotations, q a rotation.
void diagonalise(Mat3 s, Mat3* q, Vec3* values) {
  q->setIdentity();
  const double tiny = 1e-34 * s.squaredNorm();
  for (int sweep = 0; sweep < 10; ++sweep) {
    if (s(0, 1) * s(0, 1) + s(0, 2) * s(0, 2) + s(1, 2) * s(1, 2) <= tiny) break;
    for (int n = 0; n < 3; ++n) {
      const int i = (n + 1) % 3, j = (n + 2) % 3;
      const double off = s(i, j);
      if (off * off <= 1e-3 * tiny) continue;
      const double theta = 0.5 * (s(j, j) - s(i, i)) / off;
      const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
      const double cosine = 1.0 / std::sqrt(t * t + 1.0), sine = t * cosine;
      s(i, i) -= t * off;
      s(j, j) += t * off;
      s(i, j) = s(j, i) = 0.0;
      const double a = s(n, i), b = s(n, j);
      s(n, i) = s(i, n) = cosine * a - sine * b;
      s(n, j) = s(j, n) = sine * a + cosine * b;
      const Vec3 column = q->col(i);
      q->col(i) = cosine * column - sine * q->col(j);
      q->col(j) = sine * column + cosine * q->col(j);
    }
  }
  *values = s.diagonal();
}

/// Is a symmetric matrix positive definite, by a margin that round-off cannot take? By its leading minors.
bool is_positive(const Mat3& m) {
  const double size = 1e-12 * m.trace(), minor = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
  return m(0, 0) > size && minor > size * m.trace() && m.determinant() > size * m.trace() * m.trace();
}

}  // namespace

SignedSvd signed_svd(const Mat3& f) {
  SignedSvd result;
  Mat3 rotation;
  if (iterate_rotation(f, &rotation)) {
    const Mat3 stretch = rotation.transpose() * f;
    diagonalise(0.5 * (stretch + stretch.transpose()), &result.v, &result.s);
    result.u = rotation * result.v;
    return result;
  }
  const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  result = {svd.matrixU(), svd.matrixV(), svd.singularValues()};
  if (result.u.determinant() < 0.0) {
    result.u.col(2) = -result.u.col(2);
    result.s[2] = -result.s[2];
  }
  if (result.v.determinant() < 0.0) {
    result.v.col(2) = -result.v.col(2);
    result.s[2] = -result.s[2];
  }
  return result;
}

Mat3 polar_rotation(const Mat3& f) {
  Mat3 rotation;
  if (iterate_rotation(f, &rotation)) return rotation;
  const SignedSvd svd = signed_svd(f);
  return svd.u * svd.v.transpose();
}

double energy_density(const SolidMaterial& material, const Mat3& f) {
  if (material.law == SolidLaw::kHooke) {
    const Mat3 strain = 0.5 * (f + f.transpose()) - Mat3::Identity();
    const double trace = strain.trace();
    return material.mu * strain.squaredNorm() + 0.5 * material.lambda * trace * trace;
  }
  Vec3 gradient;
  return energy_density(material, signed_svd(f).s, &gradient, nullptr);
}

Mat3 first_piola(const SolidMaterial& material, const Mat3& f) {
  switch (material.law) {
    case SolidLaw::kHooke:
      return hooke(material, f);
    case SolidLaw::kCorotational:
      return corotational(material, f);
    case SolidLaw::kStVenantKirchhoff: {
      const Mat3 strain = green_lagrange(f);
      return f * (2.0 * material.mu * strain + material.lambda * strain.trace() * Mat3::Identity());
    }
    case SolidLaw::kNeoHookean:
      return neo_hookean(material, f);
    case SolidLaw::kStableNeoHookean:
      return stable_neo_hookean(material, f);
    case SolidLaw::kMooneyRivlin:
      return mooney_rivlin(material, f);
  }
  return Mat3::Zero();
}

Mat3 cauchy_stress(const SolidMaterial& material, const Mat3& f) {
  const Mat3 p = first_piola(material, f);
  return material.law == SolidLaw::kHooke ? p : Mat3(p * f.transpose() / f.determinant());
}

double von_mises(const Mat3& cauchy) {
  const Mat3 deviator = cauchy - cauchy.trace() / 3.0 * Mat3::Identity();
  return std::sqrt(1.5 * deviator.squaredNorm());
}

Mat3 cauchy_green_right(const Mat3& f) {
  return f.transpose() * f;
}

Mat3 cauchy_green_left(const Mat3& f) {
  return f * f.transpose();
}

Mat3 green_lagrange(const Mat3& f) {
  return 0.5 * (f.transpose() * f - Mat3::Identity());
}

StressDerivative stress_derivative(const SolidMaterial& material, const Mat3& f, Jacobian kind) {
  StressDerivative d;
  if (material.law == SolidLaw::kHooke) {
    d.u.setIdentity();
    d.v.setIdentity();
    d.scaling.setConstant(material.lambda);
    d.scaling.diagonal().array() += 2.0 * material.mu;
    pair_moduli(material, Vec3::Ones(), &d.twist, &d.flip);
    return d;
  }
  const SignedSvd svd = signed_svd(f);
  d.u = svd.u;
  d.v = svd.v;
  Vec3 gradient;
  energy_density(material, svd.s, &gradient, &d.scaling);
  pair_moduli(material, svd.s, &d.twist, &d.flip);
  if (kind == Jacobian::kExact) return d;
  if (!is_positive(d.scaling)) {
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(d.scaling);
    const Mat3& q = eigen.eigenvectors();
    d.scaling = q * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * q.transpose();
  }
  d.twist = d.twist.cwiseMax(0.0);
  d.flip = d.flip.cwiseMax(0.0);
  return d;
}

}  // namespace deformable_sim
