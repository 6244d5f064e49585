// What crosses what, by looking at every edge and every triangle.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/model.h"

namespace deformable_sim::test {

/// Pairs of an edge (of any sheet, skin or rope) and a triangle of the model that cross at x.
inline int count_crossings(const Model& model, const Nodes& x) {
  std::vector<std::array<int, 2>> edges;
  std::vector<std::array<int, 3>> triangles;
  for (const Body& b : model.bodies) {
    const int n = b.first_node;
    if (b.line) {
      for (int s = 0; s < b.line->segment_count(); ++s) {
        edges.push_back({n + b.line->segment(s)[0], n + b.line->segment(s)[1]});
      }
    } else {
      for (const auto& [i, j] : edges_of(*b.surface)) edges.push_back({n + i, n + j});
      for (const auto& t : b.surface->triangles) triangles.push_back({n + t[0], n + t[1], n + t[2]});
    }
  }
  const auto volume = [&](int a, int b, int c, int d) {
    const Vec3 u = x.col(b) - x.col(a), v = x.col(c) - x.col(a), w = x.col(d) - x.col(a);
    return u.cross(v).dot(w);
  };
  int count = 0;
  for (const auto& [p, q] : edges) {
    for (const auto& [a, b, c] : triangles) {
      if (p == a || p == b || p == c || q == a || q == b || q == c) continue;
      // p and q on different sides of a b c, which all turn the same way round the line p q.
      if (volume(a, b, c, p) * volume(a, b, c, q) >= 0.0) continue;
      const double ab = volume(p, q, a, b), bc = volume(p, q, b, c), ca = volume(p, q, c, a);
      if ((ab > 0.0 && bc > 0.0 && ca > 0.0) || (ab < 0.0 && bc < 0.0 && ca < 0.0)) ++count;
    }
  }
  return count;
}

}  // namespace deformable_sim::test
