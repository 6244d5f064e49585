// Singular values of the 3 x 2 deformation gradient of a sheet.
#pragma once

#include <cmath>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

using Matrix32 = Eigen::Matrix<double, 3, 2>;

/// F = s1 u1 v1^T + s2 u2 v2^T, s1 >= s2 >= 0; normal = u1 x u2.
struct PrincipalStretches {
  Eigen::Vector2d stretch;
  Matrix32 u;         // orthonormal columns
  Eigen::Matrix2d v;  // a rotation
  Vec3 normal;
};

/// One-sided Jacobi rotation: the angle t with tan 2t = 2 f1.f2 / (|f1|^2 - |f2|^2) makes the columns of F V
/// orthogonal. Small stretches keep their relative accuracy, which F^T F would lose. Where one vanishes its u is any
/// normal.
inline PrincipalStretches principal_stretches(const Matrix32& f) {
  PrincipalStretches at;
  at.v.setIdentity();
  Matrix32 g = f;
  for (int sweep = 0; sweep < 2; ++sweep) {
    const double angle =
        0.5 * std::atan2(2.0 * g.col(0).dot(g.col(1)), g.col(0).squaredNorm() - g.col(1).squaredNorm());
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    g = (g * turn).eval();
    at.v = (at.v * turn).eval();
  }
  at.stretch = g.colwise().norm();
  constexpr double kTiny = 1e-150;
  at.u.col(0) = at.stretch[0] > kTiny ? Vec3(g.col(0) / at.stretch[0]) : Vec3(Vec3::UnitX());
  Vec3 second = g.col(1) - at.u.col(0).dot(g.col(1)) * at.u.col(0);
  const double length = second.norm();
  at.u.col(1) = length > 1e-14 * at.stretch[0] && length > kTiny ? Vec3(second / length) : at.u.col(0).unitOrthogonal();
  at.normal = at.u.col(0).cross(at.u.col(1));
  return at;
}

/// The symmetric matrix without its negative eigenvalues.
inline Eigen::Matrix2d positive_part(const Eigen::Matrix2d& m) {
  const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1)), shear = m(0, 1);
  const double radius = std::hypot(half, shear);
  if (mean >= radius) return m;
  if (mean <= -radius) return Eigen::Matrix2d::Zero();
  // One eigenvalue is positive: keep its projection, (m - low I) high / (high - low).
  const double low = mean - radius, high = mean + radius;
  Eigen::Matrix2d kept = m;
  kept(1, 0) = shear;
  kept.diagonal().array() -= low;
  return (high / (high - low)) * kept;
}

}  // namespace deformable_sim
