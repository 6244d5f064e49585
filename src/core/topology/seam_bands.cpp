#include "seam_bands.h"

#include <algorithm>
#include <tuple>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/polygon_cut.h"

namespace deformable_sim {
namespace {

constexpr double kFold = 0.5;       // cosine of 60 degrees
constexpr double kTouching = 1e-3;  // of the band's width: reaches less are none

/// An edge of a triangle, in its direction there.
struct Side {
  int low, high;  // sorted ends
  int triangle;
  int index;  // from corner `index` to the next

  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][static_cast<size_t>(k)], b = mesh.triangles[t][static_cast<size_t>((k + 1) % 3)];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return sides;
}

Vec3 corner(const TriangleMesh& mesh, int triangle, int k) {
  return mesh.rest.col(mesh.triangles[static_cast<size_t>(triangle)][static_cast<size_t>(k % 3)]);
}

Vec3 face_normal(const TriangleMesh& mesh, int t) {
  return (corner(mesh, t, 1) - corner(mesh, t, 0)).cross(corner(mesh, t, 2) - corner(mesh, t, 0)).normalized();
}

SeamBand band_at(const TriangleMesh& mesh, const Side& side, double width) {
  const Vec3 a = corner(mesh, side.triangle, side.index), b = corner(mesh, side.triangle, side.index + 1);
  const Vec3 along = (b - a).normalized(), inward = face_normal(mesh, side.triangle).cross(along);
  return {{{{-inward, -inward.dot(a) - width},
            {inward, inward.dot(a)},
            {along, along.dot(a) - width},
            {-along, -along.dot(b) - width}}}};
}

bool reaches(const TriangleMesh& mesh, int triangle, const SeamBand& band, double width) {
  Polygon left{corner(mesh, triangle, 0), corner(mesh, triangle, 1), corner(mesh, triangle, 2)};
  for (const HalfSpace& bound : band.bounds) left = cut(left, bound.normal, bound.offset, kTouching * width).inside;
  return !left.empty();
}

}  // namespace

std::vector<std::array<int, 3>> border_edges(const TriangleMesh& mesh) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<std::array<int, 3>> edges;
  for (size_t s = 0; s < sides.size(); ++s) {
    const bool first_alone = s == 0 || !sides[s].same_edge(sides[s - 1]);
    const bool last_alone = s + 1 == sides.size() || !sides[s].same_edge(sides[s + 1]);
    if (!first_alone || !last_alone) continue;
    const std::array<int, 3>& t = mesh.triangles[static_cast<size_t>(sides[s].triangle)];
    const auto k = static_cast<size_t>(sides[s].index);
    edges.push_back({t[k], t[(k + 1) % 3], sides[s].triangle});
  }
  return edges;
}

SeamBands seam_bands(const TriangleMesh& mesh, double width, size_t most) {
  const std::vector<Side> sides = sorted_sides(mesh);
  std::vector<std::array<int, 3>> across(mesh.triangles.size(), {-1, -1, -1});  // neighbours that are no fold away
  std::vector<Side> seams;
  for (size_t s = 0; s < sides.size(); ++s) {
    const Side& side = sides[s];
    const bool pair = s + 1 < sides.size() && side.same_edge(sides[s + 1]);
    if (!pair) {
      seams.push_back(side);
      continue;
    }
    const Side& other = sides[++s];
    if (face_normal(mesh, side.triangle).dot(face_normal(mesh, other.triangle)) < kFold) {
      seams.push_back(side);
      seams.push_back(other);
    } else {
      across[static_cast<size_t>(side.triangle)][static_cast<size_t>(side.index)] = other.triangle;
      across[static_cast<size_t>(other.triangle)][static_cast<size_t>(other.index)] = side.triangle;
    }
  }
  SeamBands result;
  result.of_triangle.resize(mesh.triangles.size());
  std::vector<int> seen(mesh.triangles.size(), -1), front;
  size_t count = 0;
  for (const Side& seam : seams) {
    const int number = static_cast<int>(result.bands.size());
    const SeamBand band = band_at(mesh, seam, width);
    result.bands.push_back(band);
    front.assign(1, seam.triangle);
    seen[static_cast<size_t>(seam.triangle)] = number;
    while (!front.empty()) {
      const auto t = static_cast<size_t>(front.back());
      front.pop_back();
      if (!reaches(mesh, static_cast<int>(t), band, width)) continue;
      result.of_triangle[t].push_back(number);
      if (++count > most) throw InputError("seams are too wide for so fine a mesh", Code::kOutOfRange);
      for (const int next : across[t]) {
        if (next < 0 || seen[static_cast<size_t>(next)] == number) continue;
        seen[static_cast<size_t>(next)] = number;
        front.push_back(next);
      }
    }
  }
  return result;
}

}  // namespace deformable_sim
