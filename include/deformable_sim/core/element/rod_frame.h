// How a director follows a turning tangent without spinning about it.
#pragma once

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// 1 + from . to, kept off zero: between opposite tangents no smallest rotation exists.
inline double one_plus_cosine(const Vec3& from, const Vec3& to) {
  constexpr double kOpposite = 1e-12;
  return std::max(kOpposite, 1.0 + from.dot(to));
}

/// Parallel transport: the smallest rotation that takes the unit vector `from` to `to`, applied to a director normal to
/// `from`:
///
///   P(from, to) d = d - (to . d) / (1 + from . to) (from + to)
///
/// To the last bit the director itself when the tangent has not moved.
inline Vec3 transported(const Vec3& director, const Vec3& from, const Vec3& to) {
  if (from == to) return director;
  return director - (to.dot(director) / one_plus_cosine(from, to)) * (from + to);
}

/// Angle (rad) from a to b about the unit axis they are normal to, in (-pi, pi].
inline double angle_about(const Vec3& axis, const Vec3& a, const Vec3& b) {
  return std::atan2(axis.dot(a.cross(b)), a.dot(b));
}

/// The angle that differs from `angle` by whole turns and is nearest to `near`.
inline double unwrapped(double angle, double near) {
  constexpr double kTurn = 6.283185307179586;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

/// Any unit vector normal to the unit vector t.
inline Vec3 any_normal(const Vec3& t) {
  return t.unitOrthogonal();
}

/// A segment of a rod: its direction and length, with the gradient and Hessian rules of functions of the direction.
struct RodSegment {
  Vec3 tangent;
  double inverse_length;  // 1/m; 0 for a segment without length, which keeps the tangent it had

  RodSegment(const Vec3& edge, const Vec3& tangent_before) {
    constexpr double kTiny = 1e-24;  // m^2
    const double square = edge.squaredNorm();
    inverse_length = square > kTiny ? 1.0 / std::sqrt(square) : 0.0;
    tangent = square > kTiny ? Vec3(inverse_length * edge) : tangent_before;
  }

  /// dt/de = (I - t t^T) / l: from a gradient with respect to t to one with respect to the edge e.
  Vec3 by_edge(const Vec3& by_tangent) const {
    return inverse_length * (by_tangent - tangent.dot(by_tangent) * tangent);
  }
  /// The same on the left of a 3 x n matrix.
  template <class Matrix>
  Matrix rows_by_edge(const Matrix& m) const {
    return inverse_length * (m - tangent * (tangent.transpose() * m));
  }
  /// Second derivative of f(e / |e|): with gradient G and Hessian H with respect to t, and P = I - t t^T,
  ///   (P H P - (t . G) P - t (P G)^T - (P G) t^T) / l^2.
  Mat3 second_by_edge(const Vec3& g, const Mat3& h) const {
    const double along = tangent.dot(g);
    const Vec3 across = g - along * tangent;
    const Mat3 p = Mat3::Identity() - tangent * tangent.transpose();
    const Mat3 second = p * h * p - along * p - tangent * across.transpose() - across * tangent.transpose();
    return (inverse_length * inverse_length) * second;
  }
};

}  // namespace deformable_sim
