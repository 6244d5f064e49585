#include "deformable_sim/ros/robot_links.h"

#include <algorithm>

#include <ros/console.h>
#include <urdf/model.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

namespace {

/// False for a mesh.
bool to_shape(const urdf::Collision& collision, Shape* shape) {
  if (!collision.geometry) return false;
  const urdf::Geometry& geometry = *collision.geometry;
  if (geometry.type == urdf::Geometry::BOX) {
    const auto& box = static_cast<const urdf::Box&>(geometry);
    shape->type = Shape::Type::kBox;
    shape->size = Vec3(box.dim.x, box.dim.y, box.dim.z);
  } else if (geometry.type == urdf::Geometry::SPHERE) {
    shape->type = Shape::Type::kSphere;
    shape->size = Vec3(static_cast<const urdf::Sphere&>(geometry).radius, 0, 0);
  } else if (geometry.type == urdf::Geometry::CYLINDER) {
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    shape->type = Shape::Type::kCylinder;
    shape->size = Vec3(cylinder.radius, cylinder.length, 0);
  } else {
    return false;
  }
  const urdf::Pose& origin = collision.origin;
  const Eigen::Quaterniond q(origin.rotation.w, origin.rotation.x, origin.rotation.y, origin.rotation.z);
  shape->collider_from_shape =
      Eigen::Translation3d(origin.position.x, origin.position.y, origin.position.z) * q.normalized();
  return true;
}

}  // namespace

std::vector<Collider> robot_links(const std::string& urdf_xml, const RobotSpec& spec) {
  urdf::Model model;
  if (!model.initString(urdf_xml)) throw InputError("robot_description: not a URDF that can be read");
  for (const std::string& name : spec.links) {
    if (model.getLink(name)) continue;
    std::string known;
    for (const auto& [link, pointer] : model.links_) known += (known.empty() ? "" : ", ") + link;
    throw InputError("robot: link '" + name + "' is not in robot_description; its links are " + known, Code::kNotFound);
  }
  std::vector<Collider> colliders;
  for (const auto& [name, link] : model.links_) {
    if (!spec.links.empty() && std::find(spec.links.begin(), spec.links.end(), name) == spec.links.end()) continue;
    Collider collider;
    collider.name = kRobotPrefix + name;
    collider.frame = name;
    collider.friction = spec.friction;
    for (const auto& collision : link->collision_array) {
      Shape shape;
      if (collision && to_shape(*collision, &shape)) {
        collider.shapes.push_back(shape);
      } else {
        ROS_WARN_STREAM_NAMED(
            "robot", "link " << name << ": a collision mesh is left out; boxes, spheres and cylinders are used");
      }
    }
    if (!collider.shapes.empty()) colliders.push_back(collider);
  }
  return colliders;
}

}  // namespace deformable_sim
