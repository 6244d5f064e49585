// Twist at a joint of a rod.
#pragma once

#include "deformable_sim/core/element/rod_strain.h"

namespace deformable_sim {

/// The twist of a joint is the angle difference of its segments plus the twist of the reference directors:
///
///   m = angle_b - angle_a + r,   r = angle about t_b from P(t_a, t_b) u_a to u_b,
///
/// where u_a = P(t0_a, t_a) of the director stored with the tangent t0_a, u_b likewise. r is the area, on the unit
/// sphere, of the loop t0_a -> t_a -> t_b -> t0_b (and a constant): with h(p, q) = p x q / (1 + p.q)
///
///   dr/dt_a = h(t0_a, t_a) + h(t_a, t_b),   dr/dt_b = h(t_a, t_b) + h(t_b, t0_b),
///
/// h(t_a, t_b) being half the curvature binormal [Bergou 2008, holonomy], the others zero where the tangents are those
/// stored. All are normal to the tangent they belong to.
class RodTwist {
 public:
  RodTwist(const Vec3& a, const Vec3& a_before, const Vec3& b, const Vec3& b_before)
      : a_(a), a_before_(a_before), b_(b), b_before_(b_before) {}

  /// r, nearest to its last value: beyond half a turn an angle alone is ambiguous.
  static double reference(const Vec3& a, const Vec3& director_a, const Vec3& b, const Vec3& director_b, double before) {
    return unwrapped(angle_about(b, transported(director_a, a, b), director_b), before);
  }

  RodGradient gradient() const {
    const Vec3 between = half_binormal(a_, b_);
    return {half_binormal(a_before_, a_) + between, between + half_binormal(b_, b_before_), -1.0, 1.0};
  }

  /// Second derivative of m with respect to the edges: d/de (h / l), h being normal to t.
  RodMatrix second_by_edges(const RodSegment& a, const RodSegment& b) const {
    const RodGradient g = gradient();
    RodMatrix m = RodMatrix::Zero();
    m.block<3, 3>(0, 0) = second(a, g.a, by_second(a_before_, a_) + by_first(a_, b_));
    m.block<3, 3>(3, 3) = second(b, g.b, by_second(a_, b_) + by_first(b_, b_before_));
    const Mat3 mixed = a.inverse_length * by_second(a_, b_);
    m.block<3, 3>(3, 0) = b.rows_by_edge(Mat3(mixed.transpose()));
    m.block<3, 3>(0, 3) = m.block<3, 3>(3, 0).transpose();
    return m;
  }

 private:
  static Vec3 half_binormal(const Vec3& p, const Vec3& q) { return p.cross(q) / one_plus_cosine(p, q); }
  static Mat3 cross_matrix(const Vec3& p) {
    return (Mat3() << 0, -p[2], p[1], p[2], 0, -p[0], -p[1], p[0], 0).finished();
  }
  /// dh/dq = [p]x / c - (p x q) p^T / c^2, c = 1 + p.q.
  static Mat3 by_second(const Vec3& p, const Vec3& q) {
    const double c = one_plus_cosine(p, q);
    return cross_matrix(p) / c - p.cross(q) * p.transpose() / (c * c);
  }
  /// dh/dp = -[q]x / c - (p x q) q^T / c^2.
  static Mat3 by_first(const Vec3& p, const Vec3& q) {
    const double c = one_plus_cosine(p, q);
    return -cross_matrix(q) / c - p.cross(q) * q.transpose() / (c * c);
  }
  /// ((dg/dt) P - g t^T) / l^2, symmetric but for round-off, which is taken out.
  static Mat3 second(const RodSegment& segment, const Vec3& g, const Mat3& by_tangent) {
    const Vec3& t = segment.tangent;
    const Mat3 m = by_tangent - (by_tangent * t + g) * t.transpose();
    return (0.5 * segment.inverse_length * segment.inverse_length) * (m + m.transpose());
  }

  const Vec3 &a_, &a_before_, &b_, &b_before_;
};

}  // namespace deformable_sim
