#include "deformable_sim/core/contact/solid_parts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr double kFarthest = 1e6;  // m
/// A triangle this much lower than it is long has no normal to speak of.
constexpr double kLeastHeight = 1e-9;
/// Such triangles that are mended; a mesh with more of them is refused.
constexpr int kMostRepairs = 1000;
/// Volume over (area)^1.5 below which a part is a folded sheet; a sphere has 0.094, a plate of 1 : 1000 about 4e-4.
constexpr double kLeastBulk = 1e-9;

using Triangles = std::vector<std::array<int, 3>>;

std::string place_of(const Vec3& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g %.6g %.6g)", p.x(), p.y(), p.z());
  return text;
}

void check_input(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw InputError("has no triangles");
  if (mesh.triangles.size() > static_cast<size_t>(kMostColliderTriangles))
    throw InputError("has " + std::to_string(mesh.triangles.size()) + " triangles, at most " +
                         std::to_string(kMostColliderTriangles) + " are allowed",
                     Code::kOutOfRange);
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i)
    if (!mesh.rest.col(i).allFinite() || mesh.rest.col(i).cwiseAbs().maxCoeff() > kFarthest)
      throw InputError("vertex " + std::to_string(i) + " must be finite and within 1e6 m");
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int v : mesh.triangles[t])
      if (v < 0 || v >= mesh.rest.cols())
        throw InputError("triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + " of " +
                         std::to_string(mesh.rest.cols()));
}

/// Number of the first vertex at the same place.
std::vector<int> weld(const Nodes& x) {
  const auto before = [&x](int a, int b) {
    const Vec3 p = x.col(a), q = x.col(b);
    return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
  };
  std::vector<int> order(static_cast<size_t>(x.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), before);
  std::vector<int> first(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && x.col(order[k]) == x.col(order[k - 1]);
    first[static_cast<size_t>(order[k])] = same ? first[static_cast<size_t>(order[k - 1])] : order[k];
  }
  return first;
}

/// The corner opposite to the longest side of a triangle without area; -1 for one with an area.
int flat_corner(const std::array<int, 3>& v, const Nodes& x) {
  std::array<double, 3> opposite{};
  for (size_t k = 0; k < 3; ++k) opposite[k] = (x.col(v[(k + 2) % 3]) - x.col(v[(k + 1) % 3])).norm();
  const auto longest = std::max_element(opposite.begin(), opposite.end());
  const Vec3 normal = Vec3(x.col(v[1]) - x.col(v[0])).cross(Vec3(x.col(v[2]) - x.col(v[0])));
  return normal.norm() > kLeastHeight * *longest * *longest ? -1 : static_cast<int>(longest - opposite.begin());
}

bool has(const std::array<int, 3>& triangle, int vertex) {
  return std::find(triangle.begin(), triangle.end(), vertex) != triangle.end();
}

/// A triangle without area has its middle vertex on its longest side: the triangle beyond that side is cut in two
/// there, which leaves none in between and the surface where it was.
void remove_flat(const Nodes& x, Triangles* triangles) {
  int repairs = 0;
  for (size_t t = 0; t < triangles->size();) {
    const std::array<int, 3> flat = (*triangles)[t];
    const int k = flat_corner(flat, x);
    if (k < 0) {
      ++t;
      continue;
    }
    const int middle = flat[static_cast<size_t>(k)], a = flat[static_cast<size_t>((k + 1) % 3)],
              b = flat[static_cast<size_t>((k + 2) % 3)];
    size_t beyond = 0;
    while (beyond < triangles->size() &&
           (beyond == t || !has((*triangles)[beyond], a) || !has((*triangles)[beyond], b)))
      ++beyond;
    if (beyond == triangles->size() || ++repairs > kMostRepairs)
      throw InputError("a triangle at " + place_of(x.col(a)) + " has no area");
    if (has((*triangles)[beyond], middle)) {  // the same three vertices: both go
      triangles->erase(triangles->begin() + static_cast<std::ptrdiff_t>(std::max(t, beyond)));
      triangles->erase(triangles->begin() + static_cast<std::ptrdiff_t>(std::min(t, beyond)));
    } else {
      (*triangles)[t] = (*triangles)[beyond];
      std::replace((*triangles)[beyond].begin(), (*triangles)[beyond].end(), a, middle);
      std::replace((*triangles)[t].begin(), (*triangles)[t].end(), b, middle);
    }
    t = 0;
  }
}

Triangles welded_triangles(const TriangleMesh& mesh) {
  const std::vector<int> first = weld(mesh.rest);
  Triangles kept;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<int, 3> v = mesh.triangles[t];
    for (int& i : v) i = first[static_cast<size_t>(i)];
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    kept.push_back(v);
  }
  remove_flat(mesh.rest, &kept);
  if (kept.empty()) throw InputError("has no triangle with an area");
  return kept;
}

/// The triangle across each edge.
Triangles neighbours_of(const Triangles& triangles, const Nodes& x) {
  struct Side {
    int low, high, triangle, edge;
  };
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    const std::array<int, 3>& v = triangles[static_cast<size_t>(t)];
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({v[static_cast<size_t>(k)], v[static_cast<size_t>((k + 1) % 3)]});
      sides.push_back({low, high, t, k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  Triangles across(triangles.size());
  for (size_t i = 0; i < sides.size();) {
    size_t end = i + 1;
    while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
    const std::string edge = "the edge from " + place_of(x.col(sides[i].low)) + " to " + place_of(x.col(sides[i].high));
    if (end - i == 1) throw InputError("is not closed: " + edge + " belongs to one triangle only");
    if (end - i > 2) throw InputError(edge + " belongs to " + std::to_string(end - i) + " triangles, two are allowed");
    for (size_t k : {i, i + 1}) {
      const Side& other = sides[k == i ? i + 1 : i];
      across[static_cast<size_t>(sides[k].triangle)][static_cast<size_t>(sides[k].edge)] = other.triangle;
    }
    i = end;
  }
  return across;
}

bool runs_along(const std::array<int, 3>& triangle, int from, int to) {
  for (size_t k = 0; k < 3; ++k)
    if (triangle[k] == from && triangle[(k + 1) % 3] == to) return true;
  return false;
}

/// Winds every part like its first triangle and returns the number of the part of each triangle.
std::vector<int> wind_alike(const Triangles& across, const Nodes& x, Triangles* triangles) {
  std::vector<int> part(triangles->size(), -1);
  std::vector<int> front;
  int parts = 0;
  for (size_t seed = 0; seed < triangles->size(); ++seed) {
    if (part[seed] >= 0) continue;
    part[seed] = parts;
    front.push_back(static_cast<int>(seed));
    while (!front.empty()) {
      const auto t = static_cast<size_t>(front.back());
      front.pop_back();
      const std::array<int, 3> v = (*triangles)[t];
      for (const int n : across[t]) {
        std::array<int, 3>& other = (*triangles)[static_cast<size_t>(n)];
        bool alike = true;
        for (size_t k = 0; k < 3; ++k) alike = alike && !runs_along(other, v[k], v[(k + 1) % 3]);
        if (part[static_cast<size_t>(n)] >= 0) {
          if (!alike) throw InputError("has a surface with one side only, at " + place_of(x.col(v[0])));
          continue;
        }
        if (!alike) std::swap(other[1], other[2]);
        part[static_cast<size_t>(n)] = parts;
        front.push_back(n);
      }
    }
    ++parts;
  }
  return part;
}

/// Turns the part inside out when its volume is negative.
void turn_outwards(const Nodes& x, Triangles* triangles) {
  const Vec3 origin = x.col(triangles->front()[0]);
  double volume = 0.0, area = 0.0;
  for (const std::array<int, 3>& v : *triangles) {
    const Vec3 a = x.col(v[0]) - origin, b = x.col(v[1]) - origin, c = x.col(v[2]) - origin;
    volume += a.dot(b.cross(c)) / 6.0;
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  if (std::abs(volume) < kLeastBulk * area * std::sqrt(area))
    throw InputError("encloses no volume, at " + place_of(origin));
  if (volume > 0.0) return;
  for (std::array<int, 3>& v : *triangles) std::swap(v[1], v[2]);
}

/// Numbers the vertices anew, one for each fan of triangles around a place: two cones tip to tip have two tips.
SolidPart number_vertices(const Nodes& x, const Triangles& triangles) {
  SolidPart part;
  part.neighbours = neighbours_of(triangles, x);
  part.triangles.assign(triangles.size(), {{-1, -1, -1}});
  for (size_t seed = 0; seed < triangles.size(); ++seed) {
    for (size_t corner = 0; corner < 3; ++corner) {
      if (part.triangles[seed][corner] >= 0) continue;
      const int place = triangles[seed][corner];
      const auto number = static_cast<int>(part.vertices.size());
      part.vertices.push_back(x.col(place));
      size_t t = seed;
      do {  // around the fan: over the edge that leaves the vertex
        const std::array<int, 3>& v = triangles[t];
        const size_t k = v[0] == place ? 0 : v[1] == place ? 1 : 2;
        part.triangles[t][k] = number;
        t = static_cast<size_t>(part.neighbours[t][k]);
      } while (t != seed);
    }
  }
  return part;
}

}  // namespace

std::vector<SolidPart> split_into_solids(const TriangleMesh& mesh) {
  check_input(mesh);
  Triangles triangles = welded_triangles(mesh);
  const std::vector<int> part_of = wind_alike(neighbours_of(triangles, mesh.rest), mesh.rest, &triangles);
  const int count = 1 + *std::max_element(part_of.begin(), part_of.end());
  std::vector<Triangles> of_part(static_cast<size_t>(count));
  for (size_t t = 0; t < triangles.size(); ++t) of_part[static_cast<size_t>(part_of[t])].push_back(triangles[t]);
  std::vector<SolidPart> parts;
  for (Triangles& t : of_part) {
    turn_outwards(mesh.rest, &t);
    parts.push_back(number_vertices(mesh.rest, t));
  }
  return parts;
}

}  // namespace deformable_sim
