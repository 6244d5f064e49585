// The angle between two triangles that share an edge: four points.
#pragma once

#include <cmath>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Points a, b (the edge), c (triangle a b c), d (triangle b a d). With e = b - a, p = c - a, q = d - a and the normals
/// N1 = e x p, N2 = q x e of twice the triangles' areas,
///
///   angle = atan2((N2 x N1).e / |e|, N1.N2)   in (-pi, pi], > 0 where the outer side is concave
///   d angle / dp = u1 = |e| N1 / |N1|^2,      d angle / dq = u2 = |e| N2 / |N2|^2
///   d angle / de = -(p.e / e.e) u1 - (q.e / e.e) u2
///
/// Flat, the angle is the jump of slope across the edge. Where a triangle or the edge vanishes, its direction is
/// undefined and its part of the derivatives zero.
class Hinge {
 public:
  using Points = Eigen::Matrix<double, 3, 4>;  // a, b, c, d
  using Hessian = Eigen::Matrix<double, 12, 12>;

  explicit Hinge(const Points& x)
      : e_(x.col(1) - x.col(0)),
        p_(x.col(2) - x.col(0)),
        q_(x.col(3) - x.col(0)),
        n1_(e_.cross(p_)),
        n2_(q_.cross(e_)),
        square_(e_.squaredNorm()),
        length_(std::sqrt(square_)),
        inverse1_(inverse(n1_, square_)),
        inverse2_(inverse(n2_, square_)),
        along1_(square_ > 0.0 ? p_.dot(e_) / square_ : 0.0),
        along2_(square_ > 0.0 ? q_.dot(e_) / square_ : 0.0) {}

  /// rad
  double angle() const {
    if (inverse1_ == 0.0 || inverse2_ == 0.0) return 0.0;
    return std::atan2(n2_.cross(n1_).dot(e_) / length_, n1_.dot(n2_));
  }

  /// 1/m, by the points.
  Points gradient() const {
    const Vec3 u1 = (length_ * inverse1_) * n1_, u2 = (length_ * inverse2_) * n2_;
    Points g;
    g.col(0) = (along1_ - 1.0) * u1 + (along2_ - 1.0) * u2;
    g.col(1) = -along1_ * u1 - along2_ * u2;
    g.col(2) = u1;
    g.col(3) = u2;
    return g;
  }

  /// 1/m^2, by the points; symmetric to the last bit.
  Hessian hessian() const {
    Eigen::Matrix<double, 9, 9> h = Eigen::Matrix<double, 9, 9>::Zero();  // by e, p, q
    const Side side1 = side(n1_, inverse1_, p_, along1_, 1.0), side2 = side(n2_, inverse2_, q_, along2_, -1.0);
    h.block<3, 3>(0, 0) = symmetric(side1.edge_edge + side2.edge_edge);
    h.block<3, 3>(3, 3) = symmetric(side1.tip_tip);
    h.block<3, 3>(6, 6) = symmetric(side2.tip_tip);
    h.block<3, 3>(3, 0) = side1.tip_edge;
    h.block<3, 3>(6, 0) = side2.tip_edge;
    h.block<3, 3>(0, 3) = side1.tip_edge.transpose();
    h.block<3, 3>(0, 6) = side2.tip_edge.transpose();
    // e = b - a, p = c - a, q = d - a.
    Hessian by_points;
    by_points.bottomRightCorner<9, 9>() = h;
    by_points.topRightCorner<3, 9>() = -(h.topRows<3>() + h.middleRows<3>(3) + h.bottomRows<3>());
    by_points.bottomLeftCorner<9, 3>() = by_points.topRightCorner<3, 9>().transpose();
    const auto top = by_points.topRightCorner<3, 9>();
    by_points.topLeftCorner<3, 3>() = symmetric(-(top.leftCols<3>() + top.middleCols<3>(3) + top.rightCols<3>()));
    return by_points;
  }

 private:
  /// Second derivatives of one triangle's part: u by its tip and by the edge, and of the edge's gradient -along u.
  struct Side {
    Mat3 tip_tip, tip_edge, edge_edge;
  };

  /// `turn` is 1 for N = e x tip, -1 for N = tip x e.
  Side side(const Vec3& normal, double inverse, const Vec3& tip, double along, double turn) const {
    if (inverse == 0.0) return {Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
    const Vec3 u = (length_ * inverse) * normal;
    // d(N / |N|^2) = spread dN
    const Mat3 spread = length_ * inverse * (Mat3::Identity() - (2.0 * inverse) * normal * normal.transpose());
    Side s;
    s.tip_tip = turn * spread * cross(e_);
    s.tip_edge = -turn * spread * cross(tip) + u * e_.transpose() / square_;
    s.edge_edge = -along * s.tip_edge - u * (tip - 2.0 * along * e_).transpose() / square_;
    return s;
  }

  static Mat3 cross(const Vec3& a) {
    Mat3 m;
    m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
    return m;
  }
  static Mat3 symmetric(const Mat3& m) { return 0.5 * (m + m.transpose()); }
  /// 1 / |N|^2, or 0 for a triangle thinner than 1e-12 of its edge.
  static double inverse(const Vec3& normal, double edge_square) {
    const double square = normal.squaredNorm();
    return square > 1e-24 * edge_square * edge_square ? 1.0 / square : 0.0;
  }

  Vec3 e_, p_, q_, n1_, n2_;
  double square_, length_;      // of the edge
  double inverse1_, inverse2_;  // 1 / |N|^2
  double along1_, along2_;      // where the tips' feet lie on the edge
};

}  // namespace deformable_sim
