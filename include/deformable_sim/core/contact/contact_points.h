// The material points of a body that colliders are tested against.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// p = mean of x over the first `count` nodes: a node, the middle of an edge, or the centroid of a face.
struct ContactPoint {
  std::array<int, 3> node{{-1, -1, -1}};  // world node indices
  int count = 1;
  int body = 0;
};

Vec3 position(const ContactPoint& point, const Nodes& x);

/// Every node of the body.
void add_node_points(const Model& model, int body, std::vector<ContactPoint>* points);
/// Middles of all edges and centroids of all faces of a cloth; middles of all segments of a rope.
void add_between_points(const Model& model, int body, std::vector<ContactPoint>* points);

/// A run of points lying together, for culling.
struct PointBlock {
  int first = 0, last = 0;  // [first, last)
};

/// Reorders `points` so that blocks of at most `size` neighbours in space stand together, and returns the blocks.
std::vector<PointBlock> sort_into_blocks(const Nodes& x, int size, std::vector<ContactPoint>* points);

}  // namespace deformable_sim
