// Gauge pressure inside a closed surface, on one of its triangles: three points.
#pragma once

#include <Eigen/Geometry>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// The energy -p V of a gauge pressure p (Pa) that something keeps up once it has risen to it, V (m^3) the volume below
/// one triangle of a closed surface that is wound counter-clockwise from outside:
///
///   V = x0 . (x1 x x2) / 6,   f0 = p (x1 x x2) / 6   and in turn.
///
/// Over a closed surface the forces are p times a third of the area vectors around each point, wherever the origin
/// lies. Not good at: open surfaces, where they are not; a sealed volume of gas, whose pressure rises as it shrinks.
struct EnclosedPressure {
  static constexpr int kPoints = 3;
  static constexpr bool kPairwise = false;
  static constexpr bool kUniform = false;
  static constexpr bool kMayBeNegative = true;
  using Points = Eigen::Matrix3d;  // one column a corner
  using Blocks = Eigen::Matrix<double, 9, 9>;

  struct Rest {};
  struct Parameters {
    double pressure;  // p, Pa
    double rise;      // s from time 0 on, in proportion; 0 = at once
  };
  using Context = double;  // p now
  static double context(const Parameters& parameters, double time) {
    return time < parameters.rise ? parameters.pressure * time / parameters.rise : parameters.pressure;
  }

  static double energy(const Points& x, const Rest&, double pressure) { return -pressure * x.determinant() / 6.0; }

  static Points force(const Points& x, const Points& /*v*/, const Rest&, double pressure) {
    Points f;
    for (int k = 0; k < 3; ++k) f.col(k) = (pressure / 6.0) * x.col((k + 1) % 3).cross(x.col((k + 2) % 3));
    return f;
  }

  /// dx df/dx, exact: its blocks are skew, and as a whole symmetric with eigenvalues of either sign. Left out of
  /// projections.
  static Blocks jacobian(const Points& x, const Points& /*v*/, const Rest&, double pressure, double dx, double /*dv*/,
                         Jacobian kind) {
    Blocks blocks = Blocks::Zero();
    if (kind != Jacobian::kExact) return blocks;
    for (int k = 0; k < 3; ++k) {
      // f_k = p/6 a x b: df_k/da = -p/6 [b]x, df_k/db = p/6 [a]x.
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      blocks.block<3, 3>(3 * k, 3 * a) = (-dx * pressure / 6.0) * cross_matrix(x.col(b));
      blocks.block<3, 3>(3 * k, 3 * b) = (dx * pressure / 6.0) * cross_matrix(x.col(a));
    }
    return blocks;
  }

 private:
  static Mat3 cross_matrix(const Vec3& w) {
    return (Mat3() << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0).finished();
  }
};

}  // namespace deformable_sim
