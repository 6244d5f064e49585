#include "deformable_sim/core/contact/collider_set.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "deformable_sim/core/contact/surface_query.h"
#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

std::string shape_name(Shape::Type type) {
  switch (type) {
    case Shape::Type::kBox:
      return "box";
    case Shape::Type::kSphere:
      return "sphere";
    case Shape::Type::kCylinder:
      return "cylinder";
    case Shape::Type::kCapsule:
      return "capsule";
    case Shape::Type::kCone:
      return "cone";
    case Shape::Type::kMesh:
      return "mesh";
    case Shape::Type::kVoxels:
      return "octomap";
    case Shape::Type::kPlane:
      break;
  }
  return "plane";
}

int size_count(Shape::Type type) {
  switch (type) {
    case Shape::Type::kBox:
      return 3;
    case Shape::Type::kSphere:
      return 1;
    case Shape::Type::kCylinder:
      return 2;
    case Shape::Type::kCapsule:
      return 2;
    case Shape::Type::kCone:
      return 2;
    case Shape::Type::kMesh:
      return 1;
    case Shape::Type::kVoxels:
    case Shape::Type::kPlane:
      break;
  }
  return 0;
}

/// Furthest point from the collider's origin; 1 m when a plane makes that infinite.
double lever_of(const Collider& collider) {
  double lever = 0.0;
  for (const Shape& s : collider.shapes) {
    const double radius = s.type == Shape::Type::kPlane ? 1.0 : bounding_radius(s);
    lever = std::max(lever, s.collider_from_shape.translation().norm() + radius);
  }
  return lever;
}

}  // namespace

void check_collider(const Collider& collider) {
  const std::string who = "collider '" + collider.name + "': ";
  if (collider.name.empty()) throw InputError("a collider needs a name");
  if (collider.shapes.empty())
    throw InputError(who + "has no shape; give at least one box, sphere, cylinder, capsule, cone, mesh or plane");
  if (!std::isfinite(collider.friction) || collider.friction < 0.0)
    throw InputError(who + "friction must be a finite number >= 0");
  if (!is_valid_pose(collider.world_from_collider))
    throw InputError(who + "the pose must be finite, within 1e6 m, with a unit quaternion");
  for (const Shape& s : collider.shapes) {
    if (!is_valid_pose(s.collider_from_shape))
      throw InputError(who + "the pose of its " + shape_name(s.type) +
                       " must be finite, within 1e6 m, with a unit quaternion");
    for (int i = 0; i < size_count(s.type); ++i) {
      // A capsule without a straight part is a sphere and is allowed; a mesh has a padding only.
      const bool may_be_zero = (s.type == Shape::Type::kCapsule && i == 1) || s.type == Shape::Type::kMesh;
      const double size = s.size[i];
      if (!std::isfinite(size) || size > 1e6 || size < 0.0 || (size == 0.0 && !may_be_zero))
        throw InputError(who + "sizes of its " + shape_name(s.type) + " must be > 0 and at most 1e6 m");
    }
    if (s.type == Shape::Type::kMesh && !s.mesh) throw InputError(who + "its mesh has no triangles");
    if (s.type == Shape::Type::kVoxels && !s.voxels) throw InputError(who + "its octomap has no occupied space");
  }
}

bool lets_through(const Collider& collider, const std::string& body) {
  return std::find(collider.lets_through.begin(), collider.lets_through.end(), body) != collider.lets_through.end();
}

bool same_but_for_pose(const Collider& a, const Collider& b) {
  const auto same = [](const Shape& one, const Shape& other) {
    return one.type == other.type && one.size == other.size && one.mesh == other.mesh && one.voxels == other.voxels &&
           one.collider_from_shape.matrix() == other.collider_from_shape.matrix();
  };
  return a.name == b.name && a.friction == b.friction && a.frame == b.frame &&
         std::equal(a.shapes.begin(), a.shapes.end(), b.shapes.begin(), b.shapes.end(), same);
}

void ColliderSet::add(const Collider& collider) {
  check_collider(collider);
  for (const Collider& c : colliders_)
    if (c.name == collider.name)
      throw InputError("a collider named '" + collider.name + "' exists; remove it first or choose another name",
                       Code::kAlreadyExists);
  colliders_.push_back(collider);
  motions_.emplace_back(collider.world_from_collider);
  levers_.push_back(lever_of(collider));
}

size_t ColliderSet::find(const std::string& name) const {
  std::string known;
  for (size_t i = 0; i < colliders_.size(); ++i) {
    if (colliders_[i].name == name) return i;
    known += (known.empty() ? "" : ", ") + colliders_[i].name;
  }
  throw InputError("no collider named '" + name + "'; there are: " + (known.empty() ? "none" : known), Code::kNotFound);
}

void ColliderSet::remove(const std::string& name) {
  const auto i = static_cast<std::ptrdiff_t>(find(name));
  colliders_.erase(colliders_.begin() + i);
  motions_.erase(motions_.begin() + i);
  levers_.erase(levers_.begin() + i);
}

void ColliderSet::let_through(const std::string& name, std::vector<std::string> bodies) {
  colliders_[find(name)].lets_through = std::move(bodies);
}

std::string ColliderSet::move(const std::string& name, const Pose& target, double duration, double dt) {
  const size_t i = find(name);
  if (!is_valid_pose(target))
    throw InputError("collider '" + name + "': the pose must be finite, within 1e6 m, with a unit quaternion");
  if (!std::isfinite(duration) || duration < 0.0)
    throw InputError("collider '" + name + "': the duration must be a finite number >= 0 s");
  motions_[i].move_to(target, duration);
  const double way = FrameMotion::travel(motions_[i].pose(), target, levers_[i]);
  if (way <= max_speed_ * std::max(duration, dt) * (1.0 + 1e-9)) return "";
  char note[160];
  std::snprintf(note, sizeof note, "rate-limited to %g m/s: the pose is reached after %.3g s", max_speed_,
                way / max_speed_);
  return note;
}

void ColliderSet::advance(double dt, std::vector<PoseStep>* steps) {
  steps->resize(colliders_.size());
  for (size_t i = 0; i < colliders_.size(); ++i) {
    (*steps)[i].begin = motions_[i].pose();
    motions_[i].advance(dt, max_speed_, levers_[i]);
    (*steps)[i].end = motions_[i].pose();
    colliders_[i].world_from_collider = motions_[i].pose();
  }
}

void ColliderSet::restore_motions(const std::vector<FrameMotion>& motions) {
  motions_ = motions;
  for (size_t i = 0; i < colliders_.size(); ++i) colliders_[i].world_from_collider = motions_[i].pose();
}

}  // namespace deformable_sim
