#include "deformable_sim/core/contact/body_distance.h"

#include <algorithm>
#include <array>
#include <limits>

#include "deformable_sim/core/contact/surface_query.h"

namespace deformable_sim {
namespace {

constexpr double kTolerance = 1e-8;  // m
constexpr int kMostCuts = 40;        // of a piece: below any length in meters

/// Linear functions that bound a distance from below: height + normal . (x - p).
struct Tangent {
  double height;
  Vec3 normal;
};

struct Corner {
  Vec3 p;
  double seen = 0.0;  // m, within which there is nothing but what the tangents are of
  std::vector<Tangent> tangents;
};

/// One placed shape and the nearest point found so far, of all shapes.
class Search {
 public:
  Search(const Shape& shape, const Pose& world_from_shape, int collider, double radius, BodyDistance* best)
      : query_(shape),
        origin_(world_from_shape.translation()),
        concave_(query_.concave_pieces() > 0),
        collider_(collider),
        radius_(radius),
        best_(best) {
    query_.place(world_from_shape);
  }

  void look_at_node(const Vec3& p) {
    SurfacePoint found;
    if (!query_.find(p, reach_for(p, 0.0), &found)) return;
    if (found.distance - radius_ < best_->distance) take(p, found);
    overlaps_ = overlaps_ || found.distance <= 0.0;
  }

  /// count: 2 or 3 corners.
  void look_at_piece(const std::array<Vec3, 3>& x, int count) {
    // As deep as its deepest node.
    if (concave_ && overlaps_) return;
    double size = 0.0;
    for (int k = 0; k < count; ++k)
      for (int j = 0; j < k; ++j) size = std::max(size, (x[index(k)] - x[index(j)]).norm());
    std::array<Corner, 3> corners;
    for (int k = 0; k < count; ++k) corners[index(k)] = corner_at(x[index(k)], size);
    refine(corners, count, size, 0);
  }

 private:
  static size_t index(int k) { return static_cast<size_t>(k); }

  /// What is further from p cannot be nearer than the best from anywhere within `size` of p.
  double reach_for(const Vec3& p, double size) const {
    return std::min(farthest(p), std::max(0.0, best_->distance + radius_) + size);
  }
  /// No nearest point of the shape is further.
  double farthest(const Vec3& p) const { return (p - origin_).norm() + query_.bounding_radius() + 1e-6; }

  void take(const Vec3& p, const SurfacePoint& found) {
    best_->distance = found.distance - radius_;
    best_->on_body = p - radius_ * found.normal;
    best_->on_collider = p - found.distance * found.normal;
    best_->collider = collider_;
  }

  Corner corner_at(const Vec3& p, double size) {
    Corner corner;
    corner.p = p;
    const double reach = reach_for(p, size);
    corner.seen = reach;
    SurfacePoint found;
    if (!query_.find(p, reach, &found)) return corner;
    if (!concave_ || reach == farthest(p)) corner.seen = std::numeric_limits<double>::infinity();
    if (concave_ && found.distance <= 0.0) {
      // The piece is cut, and no node is inside: they touch.
      overlaps_ = true;
      found.distance = 0.0;
    }
    if (found.distance - radius_ < best_->distance) take(p, found);
    if (concave_ && !overlaps_) {
      for (const SurfacePlane& plane : query_.planes(p, found, reach, 0.0))
        corner.tangents.push_back({plane.surface.distance, plane.surface.normal});
    } else {
      corner.tangents.push_back({found.distance, found.normal});
    }
    return corner;
  }

  /// Of the distance on the piece, by the tangents at one corner.
  static double bound(const Corner& at, const std::array<Corner, 3>& corners, int count) {
    double way = 0.0;
    for (int k = 0; k < count; ++k) way = std::max(way, (corners[index(k)].p - at.p).norm());
    double least = at.seen - way;
    for (const Tangent& tangent : at.tangents) {
      double lowest = std::numeric_limits<double>::infinity();
      for (int k = 0; k < count; ++k)
        lowest = std::min(lowest, tangent.height + tangent.normal.dot(corners[index(k)].p - at.p));
      least = std::min(least, lowest);
    }
    return least;
  }

  void refine(const std::array<Corner, 3>& corners, int count, double size, int cuts) {
    if ((concave_ && overlaps_) || cuts > kMostCuts) return;
    double least = -std::numeric_limits<double>::infinity();
    for (int k = 0; k < count; ++k) least = std::max(least, bound(corners[index(k)], corners, count));
    if (least - radius_ >= best_->distance - kTolerance) return;
    std::array<Corner, 3> middle;  // of the side from k to k + 1
    const int sides = count == 2 ? 1 : 3;
    for (int k = 0; k < sides; ++k)
      middle[index(k)] = corner_at(0.5 * (corners[index(k)].p + corners[index((k + 1) % count)].p), 0.5 * size);
    if (count == 2) {
      refine({corners[0], middle[0], {}}, 2, 0.5 * size, cuts + 1);
      refine({middle[0], corners[1], {}}, 2, 0.5 * size, cuts + 1);
      return;
    }
    // The pieces at the corners, and the one between them.
    for (int k = 0; k < 3; ++k)
      refine({corners[index(k)], middle[index(k)], middle[index((k + 2) % 3)]}, 3, 0.5 * size, cuts + 1);
    refine(middle, 3, 0.5 * size, cuts + 1);
  }

  SurfaceQuery query_;
  Vec3 origin_;
  bool concave_;
  bool overlaps_ = false;
  int collider_;
  double radius_;
  BodyDistance* best_;
};

void look_at_pieces(const Body& body, const Nodes& x, Search* search) {
  const auto at = [&](int node) -> Vec3 { return x.col(body.first_node + node); };
  if (body.line) {
    for (int k = 0; k < body.line->segment_count(); ++k) {
      const auto [i, j] = body.line->segment(k);
      search->look_at_piece({at(i), at(j), Vec3::Zero()}, 2);
    }
  } else if (body.surface) {
    for (const auto& t : body.surface->triangles) search->look_at_piece({at(t[0]), at(t[1]), at(t[2])}, 3);
  }
}

}  // namespace

BodyDistance body_distance(const Model& model, int body_index, const Nodes& x, const std::vector<Collider>& colliders) {
  const Body& body = model.bodies[static_cast<size_t>(body_index)];
  BodyDistance best;
  best.distance = std::numeric_limits<double>::infinity();
  for (size_t c = 0; c < colliders.size(); ++c) {
    for (const Shape& shape : colliders[c].shapes) {
      Search search(shape, colliders[c].world_from_collider * shape.collider_from_shape, static_cast<int>(c),
                    body.contact_radius, &best);
      for (int i = 0; i < body.node_count; ++i) search.look_at_node(x.col(body.first_node + i));
      look_at_pieces(body, x, &search);
    }
  }
  return best;
}

}  // namespace deformable_sim
