// Closed meshes for contact tests, and what is to be known of them, by brute force.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim::test {

/// A prism: the outline (counter-clockwise, x y) from z = 0 up to `height`; `caps` cut the outline into triangles.
inline TriangleMesh prism(const std::vector<Eigen::Vector2d>& outline, const std::vector<std::array<int, 3>>& caps,
                          double height) {
  const auto n = static_cast<int>(outline.size());
  TriangleMesh mesh;
  mesh.rest.resize(3, 2 * n);
  for (int i = 0; i < n; ++i) {
    mesh.rest.col(i) << outline[static_cast<size_t>(i)], 0.0;
    mesh.rest.col(n + i) << outline[static_cast<size_t>(i)], height;
  }
  for (const std::array<int, 3>& c : caps) {
    mesh.triangles.push_back({{c[0], c[2], c[1]}});
    mesh.triangles.push_back({{n + c[0], n + c[1], n + c[2]}});
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({{i, j, n + j}});
    mesh.triangles.push_back({{i, n + j, n + i}});
  }
  return mesh;
}

inline TriangleMesh box_mesh(double x, double y, double z) {
  return prism({{0, 0}, {x, 0}, {x, y}, {0, y}}, {{{0, 1, 2}}, {{0, 2, 3}}}, z);
}

/// A blade of 10 degrees.
inline TriangleMesh wedge_mesh() {
  return prism({{0, 0}, {0.2, 0}, {0.2, 0.2 * std::tan(10.0 * M_PI / 180.0)}}, {{{0, 1, 2}}}, 0.15);
}

/// Two legs of 0.1 m, 0.04 m thick.
inline TriangleMesh l_mesh() {
  return prism({{0, 0}, {0.1, 0}, {0.1, 0.04}, {0.04, 0.04}, {0.04, 0.1}, {0, 0.1}},
               {{{0, 1, 2}}, {{0, 2, 3}}, {{0, 3, 4}}, {{0, 4, 5}}}, 0.08);
}

/// A channel with walls and floor of 2 mm.
inline TriangleMesh channel_mesh() {
  const double a = 0.1, b = 0.06, t = 0.002;
  return prism({{0, 0}, {a, 0}, {a, b}, {a - t, b}, {a - t, t}, {t, t}, {t, b}, {0, b}},
               {{{0, 1, 4}}, {{0, 4, 5}}, {{1, 2, 3}}, {{1, 3, 4}}, {{0, 5, 6}}, {{0, 6, 7}}}, 0.2);
}

/// Rings of a sphere of `radius`: 2 * around * (rings - 1) triangles. `bowl` turns its upper half inwards to a bowl
/// with a wall of `wall`.
inline TriangleMesh round_mesh(double radius, int rings, int around, double wall = 0.0) {
  std::vector<std::array<double, 2>> profile;  // distance from the axis, z
  const auto arc = [&](double r, double from, double to, int steps) {
    for (int k = 0; k <= steps; ++k) {
      const double a = from + (to - from) * k / steps;
      profile.push_back({{r * std::sin(a), r * std::cos(a)}});
    }
  };
  if (wall == 0.0) {
    arc(radius, M_PI, 0.0, rings);
  } else {
    arc(radius, M_PI, 0.5 * M_PI, rings);
    arc(radius - wall, 0.5 * M_PI, M_PI, rings);
  }
  TriangleMesh mesh;
  const auto count = static_cast<int>(profile.size());
  mesh.rest.resize(3, 2 + (count - 2) * around);
  mesh.rest.col(0) << 0.0, 0.0, profile.front()[1];
  mesh.rest.col(1) << 0.0, 0.0, profile.back()[1];
  const auto node = [around](int ring, int k) { return 2 + (ring - 1) * around + k % around; };
  for (int r = 1; r < count - 1; ++r) {
    for (int k = 0; k < around; ++k) {
      const double a = 2.0 * M_PI * k / around;
      const std::array<double, 2>& at = profile[static_cast<size_t>(r)];
      mesh.rest.col(node(r, k)) << at[0] * std::cos(a), at[0] * std::sin(a), at[1];
    }
  }
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({{0, node(1, k + 1), node(1, k)}});
    mesh.triangles.push_back({{1, node(count - 2, k), node(count - 2, k + 1)}});
    for (int r = 1; r < count - 2; ++r) {
      mesh.triangles.push_back({{node(r, k), node(r, k + 1), node(r + 1, k + 1)}});
      mesh.triangles.push_back({{node(r, k), node(r + 1, k + 1), node(r + 1, k)}});
    }
  }
  return mesh;
}

inline std::array<Vec3, 3> corners_of(const TriangleMesh& mesh, size_t triangle) {
  const std::array<int, 3>& v = mesh.triangles[triangle];
  return {mesh.rest.col(v[0]), mesh.rest.col(v[1]), mesh.rest.col(v[2])};
}

/// |p - q| of the nearest q = a + s (b - a) + t (c - a), s, t >= 0, s + t <= 1: where the gradient vanishes if that is
/// in the triangle, else on an edge.
inline double triangle_distance(const Vec3& p, const std::array<Vec3, 3>& x) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << x[1] - x[0], x[2] - x[0];
  const Eigen::Vector2d st = edges.colPivHouseholderQr().solve(p - x[0]);
  double best = std::numeric_limits<double>::infinity();
  if (st.minCoeff() >= 0.0 && st.sum() <= 1.0) best = (x[0] + edges * st - p).norm();
  for (size_t k = 0; k < 3; ++k) {
    const Vec3 edge = x[(k + 1) % 3] - x[k];
    const double along = std::clamp(edge.dot(p - x[k]) / edge.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (x[k] + along * edge - p).norm());
  }
  return best;
}

/// How often the surface goes around p: the solid angle of all triangles over 4 pi; 1 inside, 0 outside.
inline double winding_number(const Vec3& p, const TriangleMesh& mesh) {
  double angle = 0.0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3, 3> x = corners_of(mesh, t);
    const Vec3 a = x[0] - p, b = x[1] - p, c = x[2] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    angle += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return angle / (4.0 * M_PI);
}

inline double brute_distance(const Vec3& p, const TriangleMesh& mesh) {
  double best = std::numeric_limits<double>::infinity();
  for (size_t t = 0; t < mesh.triangles.size(); ++t) best = std::min(best, triangle_distance(p, corners_of(mesh, t)));
  return winding_number(p, mesh) > 0.5 ? -best : best;
}

/// Does the way from p to q meet triangle x? Rounding decides on its very edge.
inline bool crosses(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& x) {
  const Vec3 n = (x[1] - x[0]).cross(x[2] - x[0]);
  const double from = n.dot(p - x[0]), to = n.dot(q - x[0]);
  if ((from > 0.0) == (to > 0.0)) return false;
  const Vec3 at = p + (from / (from - to)) * (q - p);
  for (size_t k = 0; k < 3; ++k)
    if (n.dot((x[(k + 1) % 3] - x[k]).cross(at - x[k])) < 0.0) return false;
  return true;
}

inline bool crosses(const Vec3& p, const Vec3& q, const TriangleMesh& mesh) {
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    if (crosses(p, q, corners_of(mesh, t))) return true;
  return false;
}

}  // namespace deformable_sim::test
