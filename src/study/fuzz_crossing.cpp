#include "fuzz_crossing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace deformable_sim::fuzz {
namespace {

constexpr double kInPlane = 1e-9;  // m: an edge that ends nearer to the plane of a triangle lies in it

template <size_t N>
struct Part {
  int body;
  std::array<int, N> node;
  Vec3 low, high;  // m, its box

  bool has(int which) const { return std::find(node.begin(), node.end(), which) != node.end(); }
};

template <size_t N>
Part<N> part(int body, const std::array<int, N>& nodes, const Nodes& x) {
  Part<N> p{body, nodes, x.col(nodes[0]), x.col(nodes[0])};
  for (const int i : nodes) {
    p.low = p.low.cwiseMin(x.col(i));
    p.high = p.high.cwiseMax(x.col(i));
  }
  return p;
}

bool kept_apart(const Model& model, int one, int other) {
  const BodyContact a = model.bodies[static_cast<size_t>(one)].touches,
                    b = model.bodies[static_cast<size_t>(other)].touches;
  return one == other ? a == BodyContact::kAll : a != BodyContact::kNone && b != BodyContact::kNone;
}

/// The ends of the edge on different sides of the triangle, whose corners all turn the same way round the edge.
bool cross(const Part<2>& edge, const Part<3>& triangle, const Nodes& x) {
  const auto volume = [&x](int a, int b, int c, int d) {
    const Vec3 u = x.col(b) - x.col(a), v = x.col(c) - x.col(a), w = x.col(d) - x.col(a);
    return u.cross(v).dot(w);
  };
  const auto [p, q] = edge.node;
  const auto [a, b, c] = triangle.node;
  const double above = volume(a, b, c, p), below = volume(a, b, c, q);
  const double area = (x.col(b) - x.col(a)).cross(x.col(c) - x.col(a)).norm();  // twice
  if (above * below >= 0.0 || std::min(std::abs(above), std::abs(below)) < kInPlane * area) return false;
  const double ab = volume(p, q, a, b), bc = volume(p, q, b, c), ca = volume(p, q, c, a);
  return (ab > 0.0 && bc > 0.0 && ca > 0.0) || (ab < 0.0 && bc < 0.0 && ca < 0.0);
}

constexpr int kMostHeld = 4;  // of an edge's and a triangle's five nodes: held ones go through each other

}  // namespace

std::string find_crossing(const Model& model, const Nodes& x, const std::vector<char>& held) {
  std::vector<Part<2>> edges;
  std::vector<Part<3>> triangles;
  for (int k = 0; k < static_cast<int>(model.bodies.size()); ++k) {
    const Body& body = model.bodies[static_cast<size_t>(k)];
    if (body.touches == BodyContact::kNone) continue;
    const int n = body.first_node;
    if (body.line) {
      for (int s = 0; s < body.line->segment_count(); ++s) {
        const auto ends = body.line->segment(s);
        edges.push_back(part<2>(k, {n + ends[0], n + ends[1]}, x));
      }
    } else {
      for (const auto& [i, j] : edges_of(*body.surface)) edges.push_back(part<2>(k, {n + i, n + j}, x));
      for (const auto& t : body.surface->triangles) triangles.push_back(part<3>(k, {n + t[0], n + t[1], n + t[2]}, x));
    }
  }
  const auto is_held = [&held](int node) { return held[static_cast<size_t>(node)] != 0; };
  for (const Part<3>& t : triangles) {
    const auto of_triangle = std::count_if(t.node.begin(), t.node.end(), is_held);
    for (const Part<2>& e : edges) {
      if ((e.low.array() > t.high.array()).any() || (t.low.array() > e.high.array()).any()) continue;
      if (t.has(e.node[0]) || t.has(e.node[1]) || !kept_apart(model, e.body, t.body)) continue;
      if (of_triangle + std::count_if(e.node.begin(), e.node.end(), is_held) >= kMostHeld) continue;
      if (!cross(e, t, x)) continue;
      return model.bodies[static_cast<size_t>(e.body)].name + " through " +
             model.bodies[static_cast<size_t>(t.body)].name;
    }
  }
  return "";
}

}  // namespace deformable_sim::fuzz
