// Nearest triangles of a mesh to a point.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Where on a triangle a point is: in the face, on edge k (from corner k to corner k + 1), or on corner k.
enum class TriangleFeature : char { kFace, kEdge0, kEdge1, kEdge2, kCorner0, kCorner1, kCorner2 };

struct TrianglePoint {
  Vec3 point = Vec3::Zero();
  TriangleFeature feature = TriangleFeature::kFace;
  double squared_distance = 0.0;  // m^2
  int triangle = -1;
};

/// The point of triangle a, b, c nearest to p.
TrianglePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// A tree of boxes, built by FCL, walked here: FCL's own walk finds one triangle only and allocates at every query.
/// Const and safe to share between threads.
class TriangleTree {
 public:
  TriangleTree(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles);

  /// The nearest triangle of those within `reach` (m); false when there is none.
  bool nearest(const Vec3& p, double reach, TrianglePoint* found) const;
  /// Appends the nearest points of all triangles within `reach` (m).
  void within(const Vec3& p, double reach, std::vector<TrianglePoint>* found) const;

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int child;  // the first of two that stand together, or -1 - triangle
  };

  void descend(const Node& node, const Vec3& p, TrianglePoint* best) const;
  void collect(const Node& node, const Vec3& p, double squared_reach, std::vector<TrianglePoint>* found) const;
  TrianglePoint on_leaf(const Node& leaf, const Vec3& p) const;

  std::vector<Node> nodes_;
  std::vector<std::array<Vec3, 3>> corners_;
};

}  // namespace deformable_sim
