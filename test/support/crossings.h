// What crosses what, by looking at every edge and every triangle, or at every two segments.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/contact/closest_points.h"
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

/// Pairs of segments of ropes that passed through one another while x moved straight from `before` to `after`: their
/// volume changes sign where they are at no distance.
inline int count_passages(const Model& model, const Nodes& before, const Nodes& after) {
  constexpr int kParts = 64;
  std::vector<std::array<int, 2>> segments;
  for (const Body& b : model.bodies) {
    if (!b.line) continue;
    for (int s = 0; s < b.line->segment_count(); ++s) {
      segments.push_back({b.first_node + b.line->segment(s)[0], b.first_node + b.line->segment(s)[1]});
    }
  }
  const double furthest = (after - before).colwise().norm().maxCoeff();
  int count = 0;
  for (size_t i = 0; i < segments.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const auto [a, b] = segments[i];
      const auto [c, d] = segments[j];
      if (a == c || a == d || b == c || b == d) continue;
      const double apart = (before.col(a) - before.col(c)).norm();
      const double longest = (before.col(b) - before.col(a)).norm() + (before.col(d) - before.col(c)).norm();
      if (apart > longest + 2.0 * furthest) continue;
      const auto at = [&](int node, double t) -> Vec3 { return (1.0 - t) * before.col(node) + t * after.col(node); };
      const auto volume = [&, a = a, b = b, c = c, d = d](double t) {
        return (at(b, t) - at(a, t)).cross(at(d, t) - at(c, t)).dot(at(c, t) - at(a, t));
      };
      for (int k = 0; k < kParts; ++k) {
        double from = static_cast<double>(k) / kParts, to = static_cast<double>(k + 1) / kParts;
        if (volume(from) * volume(to) >= 0.0) continue;
        for (int halving = 0; halving < 50; ++halving) {
          const double middle = 0.5 * (from + to);
          (volume(from) * volume(middle) <= 0.0 ? to : from) = middle;
        }
        if (closest_segment_segment(at(a, to), at(b, to), at(c, to), at(d, to)).apart.norm() < 1e-7) ++count;
      }
    }
  }
  return count;
}

}  // namespace deformable_sim::test
