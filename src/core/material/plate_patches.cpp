#include "deformable_sim/core/material/plate_patches.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

using Vec2 = Eigen::Vector2d;
/// A linear function of the curvature (k_xx, k_yy, 2 k_xy) of w = (k_xx x^2 + k_yy y^2 + 2 k_xy x y) / 2.
using Row = Eigen::RowVector3d;

Row deflection(const Vec2& at) {
  return {0.5 * at.x() * at.x(), 0.5 * at.y() * at.y(), 0.5 * at.x() * at.y()};
}

/// Slope of w at a point along n.
Row slope(const Vec2& at, const Vec2& n) {
  return {n.x() * at.x(), n.y() * at.y(), 0.5 * (n.x() * at.y() + n.y() * at.x())};
}

/// Slope along n, the outward normal of edge p -> q, of the flat triangle through w at p, q, r.
Row flat_slope(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& n) {
  const Vec2 e = q - p;
  const double foot = (r - p).dot(e) / e.squaredNorm(), height = -(r - p).dot(n);
  return ((1.0 - foot) * deflection(p) + foot * deflection(q) - deflection(r)) / height;
}

Vec2 outward(const Vec2& p, const Vec2& q) {
  const Vec2 e = (q - p).normalized();
  return {e.y(), -e.x()};
}

/// An edge of a face: the face across (-1: none), the side of that face, the hinge (-1: none).
struct Side {
  int face = -1, side = -1, hinge = -1;
};

/// A face laid out in a plane.
struct Layout {
  std::array<Vec2, 3> corner;
};

/// Sum of coefficients times hinge angles.
using Weights = std::map<int, double>;

/// What an angle says about the curvature: angle = row . curvature, over the edge's two heights.
struct Seen {
  int hinge;
  Row row;        // m
  double height;  // m, mean distance of the two tips from the edge
};

class PlateBuilder {
 public:
  PlateBuilder(const TriangleMesh& mesh, const Mat3& stiffness, const Vec3& warp_direction)
      : mesh_(mesh), stiffness_(stiffness), warp_direction_(warp_direction), sides_(mesh.triangles.size()) {
    // Curvature = relax_ k, |k|^2 the energy: the smallest k is the one of least energy.
    relax_ = Eigen::SelfAdjointEigenSolver<Mat3>(stiffness / stiffness.trace()).operatorInverseSqrt();
    connect();
  }

  PlateMesh build() {
    std::vector<Weights> inner(plate_.hinges.size());
    for (int f = 0; f < face_count(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const Side& side = at(f, k);
        if (side.hinge >= 0 && f < side.face) inner[static_cast<size_t>(side.hinge)] = inner_slope(f, k);
      }
    }
    for (int f = 0; f < face_count(); ++f) add_patch(f, inner);
    return std::move(plate_);
  }

 private:
  int face_count() const { return static_cast<int>(mesh_.triangles.size()); }
  const Side& at(int face, int k) const { return sides_[static_cast<size_t>(face)][static_cast<size_t>(k)]; }
  int node(int face, int k) const { return mesh_.triangles[static_cast<size_t>(face)][static_cast<size_t>(k % 3)]; }

  void connect() {
    std::map<std::array<int, 2>, std::array<int, 2>> open;  // directed edge -> face, side
    for (int f = 0; f < face_count(); ++f) {
      for (int k = 0; k < 3; ++k) open[{node(f, k), node(f, k + 1)}] = {f, k};
    }
    for (int f = 0; f < face_count(); ++f) {
      for (int k = 0; k < 3; ++k) {
        const auto across = open.find({node(f, k + 1), node(f, k)});
        if (across == open.end()) continue;
        const auto [g, m] = across->second;
        Side& side = sides_[static_cast<size_t>(f)][static_cast<size_t>(k)];
        side.face = g;
        side.side = m;
        if (f > g) {
          side.hinge = at(g, m).hinge;
        } else {
          side.hinge = static_cast<int>(plate_.hinges.size());
          plate_.hinges.push_back({node(f, k), node(f, k + 1), node(f, k + 2), node(g, m + 2)});
        }
      }
    }
  }

  /// The face in its own plane, x along the warp.
  Layout own_layout(int f) const {
    const Vec3 origin = mesh_.rest.col(node(f, 0)), warp = warp_in_face(mesh_, f, warp_direction_);
    const Vec3 e1 = mesh_.rest.col(node(f, 1)) - origin, e2 = mesh_.rest.col(node(f, 2)) - origin;
    const Vec3 weft = e1.cross(e2).normalized().cross(warp);
    return {{Vec2::Zero(), Vec2(e1.dot(warp), e1.dot(weft)), Vec2(e2.dot(warp), e2.dot(weft))}};
  }

  /// The face across side k of a face laid out as `layout`, unfolded into that plane.
  Layout unfolded(int f, int k, const Layout& layout) const {
    const Side& side = at(f, k);
    const Vec2 p = layout.corner[static_cast<size_t>(k)], q = layout.corner[static_cast<size_t>((k + 1) % 3)];
    const Vec3 a = mesh_.rest.col(node(f, k)), b = mesh_.rest.col(node(f, k + 1));
    const Vec3 tip = mesh_.rest.col(node(side.face, side.side + 2)) - a, e = (b - a).normalized();
    const double along = tip.dot(e), height = (tip - along * e).norm();
    Layout other;
    other.corner[static_cast<size_t>(side.side)] = q;
    other.corner[static_cast<size_t>((side.side + 1) % 3)] = p;
    other.corner[static_cast<size_t>((side.side + 2) % 3)] = p + along * (q - p).normalized() + height * outward(p, q);
    return other;
  }

  static double area_of(const Layout& l) {
    const Vec2 a = l.corner[1] - l.corner[0], b = l.corner[2] - l.corner[0];
    return 0.5 * (a.x() * b.y() - a.y() * b.x());
  }

  /// Slope at the middle of side k along its outward normal relative to the flat face, of a quadratic w.
  static Row relative_slope(const Layout& layout, int k) {
    const Vec2 p = layout.corner[static_cast<size_t>(k)], q = layout.corner[static_cast<size_t>((k + 1) % 3)];
    const Vec2 r = layout.corner[static_cast<size_t>((k + 2) % 3)], n = outward(p, q);
    return slope(0.5 * (p + q), n) - flat_slope(p, q, r, n);
  }

  /// The hinge across side k of a face.
  Seen seen(int f, int k, const Layout& layout) const {
    const Side& side = at(f, k);
    const Layout other = unfolded(f, k, layout);
    const double length =
        (layout.corner[static_cast<size_t>(k)] - layout.corner[static_cast<size_t>((k + 1) % 3)]).norm();
    return {side.hinge, relative_slope(layout, k) + relative_slope(other, side.side),
            (area_of(layout) + area_of(other)) / length};
  }

  /// Hinges of a face other than the one across side `but`.
  void see_others(int f, int but, const Layout& layout, std::vector<Seen>* found) const {
    for (int k = 0; k < 3; ++k) {
      if (k != but && at(f, k).hinge >= 0) found->push_back(seen(f, k, layout));
    }
  }

  /// psi of side k of face f, shared with the face across.
  Weights inner_slope(int f, int k) const {
    const Layout layout = own_layout(f), other = unfolded(f, k, layout);
    std::vector<Seen> around = {seen(f, k, layout)};
    see_others(f, k, layout, &around);
    see_others(at(f, k).face, at(f, k).side, other, &around);
    Weights psi = smallest_fit(around, relative_slope(layout, k) - 0.5 * around[0].row);
    psi[at(f, k).hinge] += 0.5;
    return psi;
  }

  /// The smallest c (each in units of its edge's height) with sum c_i row_i = target.
  Weights smallest_fit(const std::vector<Seen>& around, const Row& target) const {
    Eigen::MatrixXd rows(3, static_cast<Eigen::Index>(around.size()));
    for (size_t i = 0; i < around.size(); ++i) {
      rows.col(static_cast<Eigen::Index>(i)) = (around[i].row / around[i].height * relax_).transpose();
    }
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(kUnseen);
    const Eigen::VectorXd wanted = (target * relax_).transpose(), c = svd.solve(wanted);
    Weights weights;
    for (size_t i = 0; i < around.size(); ++i) {
      const double weight = c[static_cast<Eigen::Index>(i)] / around[i].height;
      if (std::abs(weight) > kNothing) weights[around[i].hinge] += weight;
    }
    return weights;
  }

  /// psi of side k of face f: the neighbour's share is what is left of the angle.
  Weights shared_slope(int f, int k, const std::vector<Weights>& inner) const {
    const Side& side = at(f, k);
    Weights psi = inner[static_cast<size_t>(side.hinge)];
    if (f < side.face) return psi;
    for (auto& entry : psi) entry.second = -entry.second;
    psi[side.hinge] += 1.0;
    return psi;
  }

  void add_patch(int f, const std::vector<Weights>& inner) {
    const Layout layout = own_layout(f);
    PlatePatch patch;
    patch.area = area_of(layout);
    patch.curvature.setZero();
    Eigen::Matrix3Xd by_free_slope(3, 0);
    std::map<int, Vec3> by_angle;
    for (int k = 0; k < 3; ++k) {
      const Vec2 p = layout.corner[static_cast<size_t>(k)], q = layout.corner[static_cast<size_t>((k + 1) % 3)];
      const Vec2 n = outward(p, q);
      const Vec3 by_slope = (q - p).norm() / patch.area * Vec3(n.x() * n.x(), n.y() * n.y(), 2.0 * n.x() * n.y());
      if (at(f, k).hinge < 0) {
        by_free_slope.conservativeResize(3, by_free_slope.cols() + 1);
        by_free_slope.rightCols<1>() = by_slope;
        continue;
      }
      for (const auto& [hinge, weight] : shared_slope(f, k, inner)) {
        by_angle.try_emplace(hinge, Vec3::Zero()).first->second += weight * by_slope;
      }
    }
    const Mat3 free_edges = without_moment_across(by_free_slope);
    for (const auto& [hinge, curvature] : by_angle) {
      patch.hinge[static_cast<size_t>(patch.count)] = hinge;
      patch.curvature.col(patch.count) = free_edges * curvature;
      ++patch.count;
    }
    if (patch.count > 0) plate_.patches.push_back(patch);
  }

  /// The slopes at free edges take the values of least energy: curvature -> curvature without moment across them.
  Mat3 without_moment_across(const Eigen::Matrix3Xd& by_slope) const {
    if (by_slope.cols() == 0) return Mat3::Identity();
    const Eigen::MatrixXd moment = by_slope.transpose() * stiffness_;
    return Mat3::Identity() - by_slope * (moment * by_slope).ldlt().solve(moment);
  }

  static constexpr double kUnseen = 1e-3;   // of the largest singular value: what hinges cannot tell apart
  static constexpr double kNothing = 1e-9;  // weights of the round-off

  const TriangleMesh& mesh_;
  const Mat3 stiffness_;
  const Vec3 warp_direction_;
  std::vector<std::array<Side, 3>> sides_;
  Mat3 relax_;
  PlateMesh plate_;
};

}  // namespace

Vec3 warp_in_face(const TriangleMesh& mesh, int face, const Vec3& warp_direction) {
  const auto& t = mesh.triangles[static_cast<size_t>(face)];
  const Vec3 e1 = mesh.rest.col(t[1]) - mesh.rest.col(t[0]), e2 = mesh.rest.col(t[2]) - mesh.rest.col(t[0]);
  if (warp_direction.isZero(0.0)) return e1.normalized();
  const Vec3 normal = e1.cross(e2).normalized();
  const Vec3 warp = warp_direction - warp_direction.dot(normal) * normal;
  if (!(warp.norm() > 1e-3 * warp_direction.norm())) {
    throw InputError("the warp direction is normal to face " + std::to_string(face) +
                     "; it must have a part in the plane of every face");
  }
  return warp.normalized();
}

PlateMesh plate_mesh(const TriangleMesh& mesh, const Mat3& stiffness, const Vec3& warp_direction) {
  return PlateBuilder(mesh, stiffness, warp_direction).build();
}

}  // namespace deformable_sim
