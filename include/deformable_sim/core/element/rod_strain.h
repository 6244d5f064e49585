// A strain of a rod's joint with its derivatives, first with respect to tangents, then with respect to edges.
#pragma once

#include "deformable_sim/core/element/rod_frame.h"

namespace deformable_sim {

/// First derivatives of one strain with respect to the tangents (or edges) of the segments a and b at a joint and to
/// their angles.
struct RodGradient {
  Vec3 a, b;
  double angle_a = 0.0, angle_b = 0.0;
};

/// Second derivatives, `ba` with rows of b and columns of a.
struct RodHessian {
  Mat3 aa, ba, bb;
  Vec3 a_angle_a, a_angle_b, b_angle_a, b_angle_b;  // of the tangent before the underscore and an angle
  double angle_a2 = 0.0, angle_b2 = 0.0;

  static RodHessian zero() {
    RodHessian h;
    h.aa = h.ba = h.bb = Mat3::Zero();
    h.a_angle_a = h.a_angle_b = h.b_angle_a = h.b_angle_b = Vec3::Zero();
    return h;
  }
};

/// Edges a and b, then the two angles.
using RodVector = Eigen::Matrix<double, 8, 1>;
using RodMatrix = Eigen::Matrix<double, 8, 8>;

inline RodVector by_edges(const RodGradient& g, const RodSegment& a, const RodSegment& b) {
  RodVector v;
  v << a.by_edge(g.a), b.by_edge(g.b), g.angle_a, g.angle_b;
  return v;
}

/// From derivatives with respect to tangents to those with respect to edges.
inline RodMatrix by_edges(const RodGradient& g, const RodHessian& h, const RodSegment& a, const RodSegment& b) {
  RodMatrix m = RodMatrix::Zero();
  m.block<3, 3>(0, 0) = a.second_by_edge(g.a, h.aa);
  m.block<3, 3>(3, 3) = b.second_by_edge(g.b, h.bb);
  const Mat3 rows = b.rows_by_edge(h.ba);
  m.block<3, 3>(3, 0) = a.rows_by_edge(Mat3(rows.transpose())).transpose();
  m.block<3, 1>(0, 6) = a.by_edge(h.a_angle_a);
  m.block<3, 1>(0, 7) = a.by_edge(h.a_angle_b);
  m.block<3, 1>(3, 6) = b.by_edge(h.b_angle_a);
  m.block<3, 1>(3, 7) = b.by_edge(h.b_angle_b);
  m.block<3, 3>(0, 3) = m.block<3, 3>(3, 0).transpose();
  m.block<2, 6>(6, 0) = m.block<6, 2>(0, 6).transpose();
  m(6, 6) = h.angle_a2;
  m(7, 7) = h.angle_b2;
  return m;
}

}  // namespace deformable_sim
