// A vertex and a triangle, or two edges: what touches when surfaces do.
#pragma once

#include "deformable_sim/core/contact/closest_points.h"

namespace deformable_sim {

/// A triangle or a segment of a surface, with the corners and edges that it answers for: each is one piece's only.
struct Piece {
  std::array<int, 3> node{{-1, -1, -1}};  // world node indices
  int count = 3;
  int body = 0;
  unsigned own_nodes = 0, own_edges = 0;  // bit k: node k, edge k to k + 1
};

/// A vertex and a triangle (1 + 3 nodes), or two edges (2 + 2).
struct Meeting {
  std::array<int, 4> node;  // world node indices
  int first;                // how many are of the first part
  const Piece *a, *b;       // what the parts are parts of
};

/// From the second part to the first, at the positions x (3 x nodes, m).
ClosestPoints closest_points(const Meeting& m, const Nodes& x);

/// How far all of the first part lies beyond all of the second along the direction, m; negative where they overlap.
double gap_along(const Vec3& direction, const Meeting& m, const Nodes& x);

}  // namespace deformable_sim
