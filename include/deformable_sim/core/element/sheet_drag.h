// Air pressure on a moving triangle: three points.
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/material/air.h"

namespace deformable_sim {

/// Drag of a flat face of area A and unit normal n in air of relative velocity u = wind - mean(v):
///
///   F = 1/2 rho C_d A |u.n| (u.n) n = c |q| q N / |N|^2,   N = A n,   q = u.N,   c = rho C_d / 2,
///
/// a third to each corner. Purely normal: no skin friction, no lift beyond it.
struct SheetDrag {
  static constexpr int kPoints = 3;
  static constexpr bool kPairwise = false;
  static constexpr bool kUniform = true;
  using Points = Eigen::Matrix3d;  // one column a corner
  using Blocks = Eigen::Matrix<double, 9, 9>;

  struct Rest {};
  using Parameters = Air;
  struct Context {
    double coefficient;  // c, kg/m^3
    Vec3 wind;           // m/s
  };
  static Context context(const Air& air, double time) {
    return {0.5 * air.density * air.drag_coefficient, air.wind_at(time)};
  }

  static double energy(const Points&, const Rest&) { return 0.0; }

  static Points force(const Points& x, const Points& v, const Rest&, const Context& air) {
    const Vec3 area = area_vector(x);
    const double square = area.squaredNorm();
    if (square < kTiny) return Points::Zero();
    const double q = (air.wind - v.rowwise().mean()).dot(area);
    const Vec3 third = (air.coefficient * std::abs(q) * q / square / 3.0) * area;
    return third.replicate<1, 3>();
  }

  /// The block of dv df/dv, symmetric and negative semi-definite. df/dx, which is neither, is left out of projections.
  static Mat3 uniform_block(const Points& x, const Points& v, const Rest&, const Context& air, double /*dx*/,
                            double dv) {
    const Vec3 area = area_vector(x);
    const double square = area.squaredNorm();
    if (square < kTiny) return Mat3::Zero();
    const double q = (air.wind - v.rowwise().mean()).dot(area);
    return (-dv * 2.0 / 9.0 * air.coefficient * std::abs(q) / square) * area * area.transpose();
  }

  /// dx df/dx + dv df/dv, exact.
  static Blocks jacobian(const Points& x, const Points& v, const Rest& rest, const Context& air, double dx, double dv) {
    const Vec3 area = area_vector(x);
    const double square = area.squaredNorm();
    if (square < kTiny) return Blocks::Zero();
    const Vec3 u = air.wind - v.rowwise().mean();
    const double q = u.dot(area);
    Blocks blocks = uniform_block(x, v, rest, air, dx, dv).replicate<3, 3>();
    const Mat3 by_area =
        (dx * air.coefficient * std::abs(q) / square / 3.0) *
        (2.0 * area * u.transpose() + q * Mat3::Identity() - (2.0 * q / square) * area * area.transpose());
    for (int k = 0; k < 3; ++k) {
      // dN/dx_k = 1/2 [opposite edge]x, the edge running with the winding.
      const Vec3 edge = 0.5 * (x.col((k + 2) % 3) - x.col((k + 1) % 3));
      Mat3 cross;
      cross << 0, -edge[2], edge[1], edge[2], 0, -edge[0], -edge[1], edge[0], 0;
      const Mat3 block = by_area * cross;
      for (int i = 0; i < 3; ++i) blocks.block<3, 3>(3 * i, 3 * k) += block;
    }
    return blocks;
  }

 private:
  static Vec3 area_vector(const Points& x) { return 0.5 * (x.col(1) - x.col(0)).cross(x.col(2) - x.col(0)); }
  static constexpr double kTiny = 1e-30;  // m^4
};

}  // namespace deformable_sim
