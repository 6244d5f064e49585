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
  static constexpr bool kUniform = true;
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
    const Flow flow = flow_at(x, v, air);
    const Vec3 half = (0.5 * air.coefficient * flow.length * flow.speed) * flow.across;
    return half.replicate<1, 2>();
  }

  /// The block of dv df/dv, symmetric and negative semi-definite. df/dx, which is neither, is left out of projections.
  static Mat3 uniform_block(const Points& x, const Points& v, const Rest&, const Context& air, double /*dx*/,
                            double dv) {
    const Flow flow = flow_at(x, v, air);
    return (-0.25 * dv * air.coefficient * flow.length) * flow.by_velocity();
  }

  /// dx df/dx + dv df/dv, exact.
  static Blocks jacobian(const Points& x, const Points& v, const Rest& rest, const Context& air, double dx, double dv) {
    Blocks blocks = uniform_block(x, v, rest, air, dx, dv).replicate<2, 2>();
    const Flow flow = flow_at(x, v, air);
    // The direction turns with d: du_n = -(u.t) dt - t (u.dt), dt = P dd / l.
    const Mat3 by_direction = flow.speed * flow.across * flow.tangent.transpose() - flow.along * flow.by_velocity() -
                              flow.speed * flow.tangent * flow.across.transpose();
    const Mat3 block = (0.5 * dx * air.coefficient) * by_direction;
    for (int i = 0; i < 2; ++i) {
      blocks.block<3, 3>(3 * i, 0) -= block;
      blocks.block<3, 3>(3 * i, 3) += block;
    }
    return blocks;
  }

 private:
  struct Flow {
    double length = 0.0;          // l, m
    Vec3 tangent = Vec3::Zero();  // t
    double along = 0.0;           // u.t, m/s
    Vec3 across = Vec3::Zero();   // u_n, m/s
    double speed = 0.0;           // |u_n|, m/s
    /// d(|u_n| u_n)/du.
    Mat3 by_velocity() const {
      if (speed < kTiny) return Mat3::Zero();
      return speed * (Mat3::Identity() - tangent * tangent.transpose()) + across * across.transpose() / speed;
    }
  };
  static Flow flow_at(const Points& x, const Points& v, const Context& air) {
    Flow flow;
    const Vec3 d = x.col(1) - x.col(0), u = air.wind - v.rowwise().mean();
    if (d.norm() < kTiny) return flow;
    flow.length = d.norm();
    flow.tangent = d / flow.length;
    flow.along = u.dot(flow.tangent);
    flow.across = u - flow.along * flow.tangent;
    flow.speed = flow.across.norm();
    return flow;
  }
  static constexpr double kTiny = 1e-15;
};

}  // namespace deformable_sim
