// A weight on the square of a distance: two points. Sums of them make any quadratic energy free of rigid motion.
#pragma once

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// E = k/2 |d|^2, force on a = k d + c w, for d = x_b - x_a, w = v_b - v_a. A weight may be negative: only the sum over
/// all links of a term must not be. Projected and exact Jacobians agree.
struct QuadraticLink {
  static constexpr int kPoints = 2;
  static constexpr bool kPairwise = true;

  struct Rest {
    double weight;   // k, N/m
    double damping;  // c, N s/m
  };
  struct Parameters {};
  struct Context {};
  static Context context(const Parameters&, double /*time*/) { return {}; }

  static double energy(const Vec3& d, const Rest& rest) { return 0.5 * rest.weight * d.squaredNorm(); }
  static Vec3 force(const Vec3& d, const Vec3& w, const Rest& rest) { return rest.weight * d + rest.damping * w; }
  static Mat3 stiffness(const Vec3&, const Vec3&, const Rest& rest, double dx, double dv, Jacobian) {
    return (dx * rest.weight + dv * rest.damping) * Mat3::Identity();
  }
};

}  // namespace deformable_sim
