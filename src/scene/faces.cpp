#include <algorithm>
#include <cmath>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/types.h"
#include "face_files.h"

namespace deformable_sim {
namespace {

constexpr size_t kMostCornersToClip = 64;  // each ear looks at all corners

/// Seen along the polygon's normal [Newell], so that "left" and "right" mean something.
struct Flat {
  std::vector<Vec3> at;
  Vec3 normal = Vec3::Zero();

  /// Positive where the path a, b, c turns left.
  double turn(size_t a, size_t b, size_t c) const { return (at[b] - at[a]).cross(at[c] - at[b]).dot(normal); }
  bool contains(size_t a, size_t b, size_t c, size_t p) const {
    return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
  }
};

Flat flatten(const std::vector<Faces::Point>& points, const std::vector<int>& polygon) {
  Flat flat;
  for (const int corner : polygon) {
    const Faces::Point& p = points[static_cast<size_t>(corner)];
    flat.at.emplace_back(p[0], p[1], p[2]);
  }
  for (size_t k = 0; k < flat.at.size(); ++k) {
    const Vec3 &a = flat.at[k], &b = flat.at[(k + 1) % flat.at.size()];
    flat.normal += (a - flat.at[0]).cross(b - flat.at[0]);
  }
  return flat;
}

/// The first corner that turns inwards; `count` when the polygon is convex.
size_t inner_corner(const Flat& flat) {
  const size_t count = flat.at.size();
  for (size_t k = 0; k < count; ++k) {
    if (flat.turn((k + count - 1) % count, k, (k + 1) % count) < 0.0) return k;
  }
  return count;
}

/// The corner of `rest`, indices into `flat`, whose triangle holds no other; the first one when none is left that does.
size_t find_ear(const Flat& flat, const std::vector<size_t>& rest) {
  const size_t count = rest.size();
  for (size_t k = 0; k < count; ++k) {
    const size_t a = rest[(k + count - 1) % count], b = rest[k], c = rest[(k + 1) % count];
    if (flat.turn(a, b, c) <= 0.0) continue;
    const bool free = std::none_of(rest.begin(), rest.end(),
                                   [&](size_t p) { return p != a && p != b && p != c && flat.contains(a, b, c, p); });
    if (free) return k;
  }
  return 0;
}

}  // namespace

void Faces::add_point(const Point& point) {
  if (points_.size() >= kMostPoints) {
    throw InputError("has more than " + std::to_string(kMostPoints) + " vertices", Code::kOutOfRange);
  }
  points_.push_back(point);
}

void Faces::add_corner(long point) {
  if (corners_.size() >= kMostCorners) {
    throw InputError("has faces of more than " + std::to_string(kMostCorners) + " corners together", Code::kOutOfRange);
  }
  corners_.push_back(point);
}

void Faces::end_face() {
  ends_.push_back(corners_.size());
}

void Faces::check() const {
  for (size_t face = 0; face < ends_.size(); ++face) {
    const size_t count = ends_[face] - begin(face);
    if (count < 3) {
      throw InputError("has a face with " + std::to_string(count) + " vertices; lines and points are no cloth");
    }
  }
  for (const long point : corners_) {
    if (point >= 0 && point < static_cast<long>(points_.size())) continue;
    throw InputError("a face names vertex " + std::to_string(point) + " of " + std::to_string(points_.size()) +
                     ", counted from 0");
  }
}

std::vector<std::array<int, 3>> Faces::triangles() const {
  std::vector<std::array<int, 3>> result;
  for (size_t face = 0; face < ends_.size(); ++face) {
    cut({corners_.begin() + static_cast<long>(begin(face)), corners_.begin() + static_cast<long>(ends_[face])},
        &result);
  }
  return result;
}

void Faces::cut(std::vector<int> polygon, std::vector<std::array<int, 3>>* out) const {
  const size_t count = polygon.size();
  if (count == 3) {
    out->push_back({polygon[0], polygon[1], polygon[2]});
    return;
  }
  const Flat flat = flatten(points_, polygon);
  const size_t inner = inner_corner(flat);
  if (count == 4 && inner < count)
    std::rotate(polygon.begin(), polygon.begin() + static_cast<long>(inner), polygon.end());
  if (count == 4 || inner == count) {
    for (size_t k = 1; k + 1 < count; ++k) out->push_back({polygon[0], polygon[k], polygon[k + 1]});
    return;
  }
  if (count > kMostCornersToClip) {
    throw InputError("has a face of " + std::to_string(count) + " corners that is not convex; at most " +
                         std::to_string(kMostCornersToClip) + " are cut, save it as triangles",
                     Code::kOutOfRange);
  }
  std::vector<size_t> rest(count);
  for (size_t k = 0; k < count; ++k) rest[k] = k;
  while (rest.size() > 3) {
    const size_t ear = find_ear(flat, rest), before = (ear + rest.size() - 1) % rest.size();
    out->push_back({polygon[rest[before]], polygon[rest[ear]], polygon[rest[(ear + 1) % rest.size()]]});
    rest.erase(rest.begin() + static_cast<long>(ear));
  }
  out->push_back({polygon[rest[0]], polygon[rest[1]], polygon[rest[2]]});
}

}  // namespace deformable_sim
