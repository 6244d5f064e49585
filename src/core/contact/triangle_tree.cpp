#include "deformable_sim/core/contact/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fcl/geometry/bvh/BVH_model.h>

namespace deformable_sim {
namespace {

TrianglePoint nearest_on_edges(const Vec3& p, const std::array<const Vec3*, 3>& corner) {
  TrianglePoint best;
  best.squared_distance = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < 3; ++k) {
    const Vec3& from = *corner[k];
    const Vec3& to = *corner[(k + 1) % 3];
    const Vec3 edge = to - from;
    const double t = edge.dot(p - from) / edge.squaredNorm();
    const Vec3 q = t <= 0.0 ? from : t >= 1.0 ? to : Vec3(from + t * edge);
    const double squared = (p - q).squaredNorm();
    if (squared >= best.squared_distance) continue;
    best.squared_distance = squared;
    best.point = q;
    best.feature = static_cast<TriangleFeature>(t <= 0.0 ? 4 + k : t >= 1.0 ? 4 + (k + 1) % 3 : 1 + k);
  }
  return best;
}

}  // namespace

TrianglePoint nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 n = (b - a).cross(c - a);
  // Seen along the normal p is on the inner side of every edge: its foot on the plane is in the face.
  const bool over_face =
      n.dot((b - a).cross(p - a)) >= 0.0 && n.dot((c - b).cross(p - b)) >= 0.0 && n.dot((a - c).cross(p - c)) >= 0.0;
  if (!over_face) return nearest_on_edges(p, {&a, &b, &c});
  TrianglePoint found;
  const double height = n.dot(p - a) / n.norm();
  found.point = p - height * n.normalized();
  found.squared_distance = height * height;
  return found;
}

TriangleTree::TriangleTree(const std::vector<Vec3>& vertices, const std::vector<std::array<int, 3>>& triangles) {
  std::vector<fcl::Triangle> faces;
  for (const std::array<int, 3>& v : triangles) {
    faces.emplace_back(static_cast<size_t>(v[0]), static_cast<size_t>(v[1]), static_cast<size_t>(v[2]));
    corners_.push_back({vertices[static_cast<size_t>(v[0])], vertices[static_cast<size_t>(v[1])],
                        vertices[static_cast<size_t>(v[2])]});
  }
  fcl::BVHModel<fcl::AABBd> model;
  model.beginModel(static_cast<int>(faces.size()), static_cast<int>(vertices.size()));
  model.addSubModel(vertices, faces);
  model.endModel();
  nodes_.reserve(static_cast<size_t>(model.getNumBVs()));
  for (int i = 0; i < model.getNumBVs(); ++i) {
    const fcl::BVNode<fcl::AABBd>& node = model.getBV(i);
    nodes_.push_back(
        {Eigen::AlignedBox3d(node.bv.min_, node.bv.max_), node.isLeaf() ? -1 - node.primitiveId() : node.leftChild()});
  }
}

TrianglePoint TriangleTree::on_leaf(const Node& leaf, const Vec3& p) const {
  const auto triangle = static_cast<size_t>(-1 - leaf.child);
  const std::array<Vec3, 3>& c = corners_[triangle];
  TrianglePoint found = nearest_on_triangle(p, c[0], c[1], c[2]);
  found.triangle = static_cast<int>(triangle);
  return found;
}

bool TriangleTree::nearest(const Vec3& p, double reach, TrianglePoint* found) const {
  found->triangle = -1;
  // A triangle exactly at the reach counts, rounding included.
  found->squared_distance = reach * reach * (1.0 + 1e-12) + std::numeric_limits<double>::min();
  descend(nodes_.front(), p, found);
  return found->triangle >= 0;
}

void TriangleTree::descend(const Node& node, const Vec3& p, TrianglePoint* best) const {
  if (node.child < 0) {
    const TrianglePoint candidate = on_leaf(node, p);
    if (candidate.squared_distance < best->squared_distance) *best = candidate;
    return;
  }
  const Node* near = &nodes_[static_cast<size_t>(node.child)];
  const Node* far = near + 1;
  double near_distance = near->box.squaredExteriorDistance(p);
  double far_distance = far->box.squaredExteriorDistance(p);
  if (far_distance < near_distance) {
    std::swap(near, far);
    std::swap(near_distance, far_distance);
  }
  if (near_distance <= best->squared_distance) descend(*near, p, best);
  if (far_distance <= best->squared_distance) descend(*far, p, best);
}

void TriangleTree::within(const Vec3& p, double reach, std::vector<TrianglePoint>* found) const {
  collect(nodes_.front(), p, reach * reach, found);
}

void TriangleTree::collect(const Node& node, const Vec3& p, double squared_reach,
                           std::vector<TrianglePoint>* found) const {
  if (node.box.squaredExteriorDistance(p) > squared_reach) return;
  if (node.child >= 0) {
    collect(nodes_[static_cast<size_t>(node.child)], p, squared_reach, found);
    collect(nodes_[static_cast<size_t>(node.child) + 1], p, squared_reach, found);
    return;
  }
  const TrianglePoint candidate = on_leaf(node, p);
  if (candidate.squared_distance <= squared_reach) found->push_back(candidate);
}

}  // namespace deformable_sim
