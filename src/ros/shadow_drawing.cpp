#include "deformable_sim/ros/shadow_drawing.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/topology/polygon_cut.h"
#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/rigid_drawing.h"
#include "deformable_sim/ros/robot_links.h"
#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

constexpr double kFlat = 0.99985;  // cosine of 1 degree
constexpr double kBelow = 2e-3;    // m, that what casts a shadow may be below what it falls on
constexpr double kSnapped = 1e-6;  // m
constexpr double kDarkness = 0.4;

/// A flat top: a rectangle of the world.
struct Top {
  Vec3 middle;
  std::array<Vec3, 2> half;  // m, of its edges
  double height;             // m, against gravity
};

void add_top(const Shape& shape, const Pose& world_from_shape, const Vec3& up, std::vector<Top>* tops) {
  const Mat3 axes = world_from_shape.linear();
  Vec3 half;
  int axis = 2;
  if (shape.type == Shape::Type::kPlane) {
    half = Vec3(0.5 * kPlaneSize, 0.5 * kPlaneSize, 0.0);
    if (axes.col(2).dot(up) < kFlat) return;
  } else if (shape.type == Shape::Type::kBox) {
    half = 0.5 * shape.size;
    (axes.transpose() * up).cwiseAbs().maxCoeff(&axis);
    if (std::abs(axes.col(axis).dot(up)) < kFlat) return;
  } else {
    return;
  }
  const double side = axes.col(axis).dot(up) > 0.0 ? 1.0 : -1.0;
  const Vec3 middle = world_from_shape.translation() + side * half[axis] * axes.col(axis);
  const int p = (axis + 1) % 3, q = (axis + 2) % 3;
  tops->push_back({middle, {half[p] * axes.col(p), half[q] * axes.col(q)}, middle.dot(up)});
}

/// The highest first.
std::vector<Top> flat_tops(const Snapshot& snapshot, const Vec3& up) {
  std::vector<Top> tops;
  for (const Collider& collider : snapshot.colliders) {
    if (collider.name.rfind(kRobotPrefix, 0) == 0) continue;
    for (const Shape& shape : collider.shapes) {
      add_top(shape, collider.world_from_collider * shape.collider_from_shape, up, &tops);
    }
  }
  std::stable_sort(tops.begin(), tops.end(), [](const Top& a, const Top& b) { return a.height > b.height; });
  return tops;
}

class Caster {
 public:
  Caster(std::vector<Top> tops, const Vec3& up, visualization_msgs::Marker* marker)
      : tops_(std::move(tops)), up_(up), marker_(marker) {}

  bool idle() const { return tops_.empty(); }

  /// The part of a polygon on each top below it, from the top numbered `first` on.
  void cast(const Polygon& polygon, std::size_t first = 0) {
    double height = 0.0;
    for (const Vec3& corner : polygon) height += corner.dot(up_) / static_cast<double>(polygon.size());
    for (std::size_t t = first; t < tops_.size(); ++t) {
      const Top& top = tops_[t];
      if (height < top.height - kBelow) continue;
      if (beside(polygon, top)) continue;
      if (within(polygon, top)) return add(polygon, top.height + kShadowLift);
      Polygon inside = polygon;
      for (const Vec3& half : top.half) {
        for (const double side : {1.0, -1.0}) {
          const Vec3 inward = -side * half.normalized();
          CutPolygon parts = cut(inside, inward, inward.dot(top.middle) - half.norm(), kSnapped);
          inside = std::move(parts.inside);
          if (!parts.outside.empty()) cast(parts.outside, t + 1);
          if (inside.empty()) return;
        }
      }
      return add(inside, top.height + kShadowLift);
    }
  }

 private:
  /// Whether one edge of the top separates them.
  static bool beside(const Polygon& polygon, const Top& top) {
    for (const Vec3& half : top.half) {
      double least = 1e300, most = -1e300;
      for (const Vec3& corner : polygon) {
        const double at = (corner - top.middle).dot(half);
        least = std::min(least, at);
        most = std::max(most, at);
      }
      if (least >= half.squaredNorm() || most <= -half.squaredNorm()) return true;
    }
    return false;
  }

  static bool within(const Polygon& polygon, const Top& top) {
    return std::all_of(polygon.begin(), polygon.end(), [&top](const Vec3& corner) {
      return std::abs((corner - top.middle).dot(top.half[0])) <= top.half[0].squaredNorm() &&
             std::abs((corner - top.middle).dot(top.half[1])) <= top.half[1].squaredNorm();
    });
  }

  void add(const Polygon& polygon, double height) {
    const auto at = [&](const Vec3& corner) { return to_point(corner + (height - corner.dot(up_)) * up_); };
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, k - 1, k}) marker_->points.push_back(at(polygon[corner]));
    }
  }

  std::vector<Top> tops_;
  Vec3 up_;
  visualization_msgs::Marker* marker_;
};

void cast_surface(const Snapshot& snapshot, const Body& body, const Vec3& up, Caster* caster) {
  const ShownColumns x = shown_positions(snapshot, body);
  Polygon polygon(3);
  for (const std::array<int, 3>& triangle : shown_surface(body)->triangles) {
    for (std::size_t k = 0; k < 3; ++k) polygon[k] = x.col(triangle[k]);
    const double facing = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]).dot(up);
    if (!body.volume || facing > 0.0) caster->cast(polygon);
  }
}

/// A band as wide as the tube, with its sides in common from one segment to the next.
void cast_line(const Snapshot& snapshot, const Body& body, const Vec3& up, Caster* caster) {
  const int n = body.node_count;
  const bool closed = body.line->closed;
  const auto at = [&](int i) -> Vec3 {
    return snapshot.x.col(body.first_node + (closed ? (i + n) % n : std::clamp(i, 0, n - 1)));
  };
  Nodes side(3, n);
  Vec3 last = up.unitOrthogonal();
  for (int i = 0; i < n; ++i) {
    const Vec3 across = up.cross(at(i + 1) - at(i - 1));
    if (across.norm() > 1e-6) last = across.normalized();  // of an upright part that of the one before
    side.col(i) = body.draw_radius * last;
  }
  for (int s = 0; s < body.line->segment_count(); ++s) {
    const auto [a, b] = body.line->segment(s);
    caster->cast({at(a) - side.col(a), at(b) - side.col(b), at(b) + side.col(b), at(a) + side.col(a)});
  }
}

}  // namespace

visualization_msgs::Marker shadow_marker(const Snapshot& snapshot, int body) {
  visualization_msgs::Marker marker = blank_marker();
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = kDarkness;
  const Vec3& gravity = snapshot.model->gravity;
  if (gravity.norm() < 1e-9) return marker;
  const Vec3 up = -gravity.normalized();
  Caster caster(flat_tops(snapshot, up), up, &marker);
  if (caster.idle()) return marker;
  const Body& shape = snapshot.model->bodies[static_cast<std::size_t>(body)];
  if (shown_surface(shape)) {
    cast_surface(snapshot, shape, up, &caster);
  } else {
    cast_line(snapshot, shape, up, &caster);
  }
  return marker;
}

}  // namespace deformable_sim
