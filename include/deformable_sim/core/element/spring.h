// A spring with a damper along it: two points.
#pragma once

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Linear spring and damper between points a and b, d = x_b - x_a, r = |d|, n = d / r, w = v_b - v_a:
///
///   E = k/2 (r - L)^2,   force on a = (k (r - L) + c n.w) n,   force on b its opposite,
///
/// so a stretched spring pulls its ends together. At r = 0 the direction is undefined: force and Jacobian are zero.
struct Spring {
  static constexpr int kPoints = 2;
  /// Depends on differences only: one 3x3 block describes the whole Jacobian (see ElementEnergy).
  static constexpr bool kPairwise = true;

  struct Rest {
    double length;     // L, m
    double stiffness;  // k, N/m
    double damping;    // c, N s/m
  };
  struct Parameters {};
  struct Context {};
  static Context context(const Parameters&, double /*time*/) { return {}; }

  /// J, from d (m).
  static double energy(const Vec3& d, const Rest& rest) {
    const double stretch = d.norm() - rest.length;
    return 0.5 * rest.stiffness * stretch * stretch;
  }

  /// N on point a, from d (m) and w (m/s).
  static Vec3 force(const Vec3& d, const Vec3& w, const Rest& rest) {
    const double r2 = d.squaredNorm();
    if (r2 < kTiny) return Vec3::Zero();
    const double r = std::sqrt(r2);
    return ((rest.stiffness * (r - rest.length) + rest.damping * d.dot(w) / r) / r) * d;
  }

  /// The same with the transverse part of another state, at which the spring was `before` (m): k (1 - L/r) is small
  /// there beside what a state off by a part of its stretch has, and it is what it will be at the solution.
  static Mat3 lagged_stiffness(const Vec3& d, const Vec3& before, const Rest& rest, double dx, double dv) {
    const double r2 = d.squaredNorm(), r2_before = before.squaredNorm();
    if (r2 < kTiny || r2_before < kTiny) return Mat3::Zero();
    const Vec3 n = d / std::sqrt(r2);
    const double transverse = std::max(0.0, dx * rest.stiffness * (1.0 - rest.length / std::sqrt(r2_before)));
    return along_and_across(n, dx * rest.stiffness + dv * rest.damping, transverse);
  }

  /// dx dF/dd + dv dF/dw, F the force on a:
  ///
  ///   dF/dd = k [n n^T + (1 - L/r) P] + c/r [(n.w) P + n (P w)^T],   P = I - n n^T
  ///   dF/dw = c n n^T
  ///
  /// Axial: the transverse part is dropped always. Projected: the transverse part (1 - L/r) P is dropped when r < L and
  /// the velocity part of dF/dd always.
  static Mat3 stiffness(const Vec3& d, const Vec3& w, const Rest& rest, double dx, double dv, Jacobian kind) {
    const double r2 = d.squaredNorm();
    if (r2 < kTiny) return Mat3::Zero();
    const double inverse = 1.0 / std::sqrt(r2);
    const Vec3 n = inverse * d;
    double transverse = dx * rest.stiffness * (1.0 - rest.length * inverse);
    if (kind == Jacobian::kAxial) {
      transverse = 0.0;
    } else if (kind == Jacobian::kProjected) {
      if (transverse < 0.0) transverse = 0.0;
    } else {
      transverse += dx * rest.damping * inverse * n.dot(w);
    }
    Mat3 h = along_and_across(n, dx * rest.stiffness + dv * rest.damping, transverse);
    if (kind == Jacobian::kExact) {
      h.noalias() += (dx * rest.damping * inverse) * n * (w - n.dot(w) * n).transpose();
    }
    return h;
  }

 private:
  /// along n n^T + across (I - n n^T)
  static Mat3 along_and_across(const Vec3& n, double along, double across) {
    const Vec3 axial = (along - across) * n;
    Mat3 h;
    h.col(0) = n[0] * axial;
    h.col(1) = n[1] * axial;
    h.col(2) = n[2] * axial;
    h(0, 0) += across;
    h(1, 1) += across;
    h(2, 2) += across;
    return h;
  }

  static constexpr double kTiny = 1e-24;  // m^2
};

}  // namespace deformable_sim
