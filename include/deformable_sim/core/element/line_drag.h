// Air drag across a thin cylinder: two points.
#pragma once

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/material/air.h"

namespace deformable_sim {

/// Cross-flow drag of a cylinder of diameter D along d = x_b - x_a, l = |d|, t = d / l, in air of relative velocity
/// u = wind - mean(v):
///
///   F = 1/2 rho C_d D l |u_n| u_n,   u_n = u - (u.t) t,
///
/// half to each end. Flow along the cylinder is not resisted.
struct LineDrag {
  static constexpr int kPoints = 2;
  static constexpr bool kPairwise = false;
  using Points = Eigen::Matrix<double, 3, 2>;  // one column an end
  using Blocks = Eigen::Matrix<double, 6, 6>;

  struct Rest {};
  struct Parameters {
    Air air;
    double diameter;  // m
  };
  struct Context {
    double coefficient;  // rho C_d D / 2, kg/m^2
    Vec3 wind;           // m/s
  };
  static Context context(const Parameters& p, double time) {
    return {0.5 * p.air.density * p.air.drag_coefficient * p.diameter, p.air.wind_at(time)};
  }

  static double energy(const Points&, const Rest&) { return 0.0; }

  static Points force(const Points& x, const Points& v, const Rest&, const Context& air) {
    const Vec3 d = x.col(1) - x.col(0);
    const double length = d.norm();
    if (length < kTiny) return Points::Zero();
    const Vec3 t = d / length, u = air.wind - v.rowwise().mean();
    const Vec3 across = u - u.dot(t) * t;
    const Vec3 half = (0.5 * air.coefficient * length * across.norm()) * across;
    return half.replicate<1, 2>();
  }

  /// dx df/dx + dv df/dv. Projected: df/dv, which is symmetric, alone; df/dx is left out.
  static Blocks jacobian(const Points& x, const Points& v, const Rest&, const Context& air, double dx, double dv,
                         Jacobian kind) {
    const Vec3 d = x.col(1) - x.col(0);
    const double length = d.norm();
    if (length < kTiny) return Blocks::Zero();
    const Vec3 t = d / length, u = air.wind - v.rowwise().mean();
    const double along = u.dot(t);
    const Vec3 across = u - along * t;
    const double speed = across.norm();
    if (speed < kTiny) return Blocks::Zero();

    const Mat3 transverse = Mat3::Identity() - t * t.transpose();
    const Mat3 square = speed * transverse + across * across.transpose() / speed;  // d(|u_n| u_n)/du
    const Mat3 by_velocity = (-0.25 * dv * air.coefficient * length) * square;
    Blocks blocks = by_velocity.replicate<2, 2>();
    if (kind == Jacobian::kProjected) return blocks;

    // The direction turns with d: du_n = -(u.t) dt - t (u.dt), dt = P dd / l; the second part leaves |u_n| u_n's
    // plane and is scaled by |u_n| alone.
    const Mat3 by_direction = speed * across * t.transpose() - along * square - speed * t * across.transpose();
    const Mat3 block = (0.5 * dx * air.coefficient) * by_direction;
    for (int i = 0; i < 2; ++i) {
      blocks.block<3, 3>(3 * i, 0) -= block;
      blocks.block<3, 3>(3 * i, 3) += block;
    }
    return blocks;
  }

 private:
  static constexpr double kTiny = 1e-15;
};

}  // namespace deformable_sim
