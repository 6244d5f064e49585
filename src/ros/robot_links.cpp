#include "deformable_sim/ros/robot_links.h"

#include <algorithm>

#include <ros/console.h>
#include <urdf/model.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/build_progress.h"
#include "deformable_sim/ros/resource.h"
#include "deformable_sim/scene/collider_file.h"
#include "deformable_sim/scene/mesh_file.h"

namespace deformable_sim {

namespace {

Pose to_pose(const urdf::Pose& origin) {
  const Eigen::Quaterniond q(origin.rotation.w, origin.rotation.x, origin.rotation.y, origin.rotation.z);
  return Eigen::Translation3d(origin.position.x, origin.position.y, origin.position.z) * q.normalized();
}

std::vector<Shape> to_shapes(const urdf::Mesh& mesh, double padding) {
  const std::string bytes = read_resource(mesh.filename);
  const Vec3 scale(mesh.scale.x, mesh.scale.y, mesh.scale.z);
  const TriangleMesh faces = faces_from_bytes(bytes, mesh.filename, scale);
  try {
    return mesh_shapes(faces, padding, build_progress(mesh.filename));
  } catch (const InputError& error) {
    throw InputError(mesh.filename + ": " + error.what(), error.code());
  }
}

/// One for a primitive, one for each closed part of a mesh.
std::vector<Shape> to_shapes(const urdf::Geometry& geometry, double padding) {
  Shape shape;
  if (geometry.type == urdf::Geometry::BOX) {
    const auto& box = static_cast<const urdf::Box&>(geometry);
    shape.type = Shape::Type::kBox;
    shape.size = Vec3(box.dim.x, box.dim.y, box.dim.z) + Vec3::Constant(2.0 * padding);
  } else if (geometry.type == urdf::Geometry::SPHERE) {
    shape.type = Shape::Type::kSphere;
    shape.size = Vec3(static_cast<const urdf::Sphere&>(geometry).radius + padding, 0, 0);
  } else if (geometry.type == urdf::Geometry::CYLINDER) {
    const auto& cylinder = static_cast<const urdf::Cylinder&>(geometry);
    shape.type = Shape::Type::kCylinder;
    shape.size = Vec3(cylinder.radius + padding, cylinder.length + 2.0 * padding, 0);
  } else if (geometry.type == urdf::Geometry::MESH) {
    return to_shapes(static_cast<const urdf::Mesh&>(geometry), padding);
  } else {
    throw InputError("a collision element is neither box, sphere, cylinder nor mesh");
  }
  return {shape};
}

void check_links(const urdf::Model& model, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (model.getLink(name)) continue;
    std::string known;
    for (const auto& [link, pointer] : model.links_) known += (known.empty() ? "" : ", ") + link;
    throw InputError("robot: link '" + name + "' is not in robot_description; its links are " + known, Code::kNotFound);
  }
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::vector<Collider> robot_links(const std::string& urdf_xml, const RobotSpec& spec) {
  urdf::Model model;
  if (!model.initString(urdf_xml)) throw InputError("robot_description: not a URDF that can be read");
  check_links(model, spec.links);
  check_links(model, spec.exclude);
  for (const auto& [link, bodies] : spec.lets_through) check_links(model, {link});
  std::vector<Collider> colliders;
  for (const auto& [name, link] : model.links_) {
    if ((!spec.links.empty() && !contains(spec.links, name)) || contains(spec.exclude, name)) continue;
    Collider collider;
    collider.name = kRobotPrefix + name;
    collider.frame = name;
    collider.friction = spec.friction;
    const auto through = spec.lets_through.find(name);
    if (through != spec.lets_through.end()) collider.lets_through = through->second;
    for (const auto& collision : link->collision_array) {
      if (!collision || !collision->geometry) continue;
      try {
        for (Shape& shape : to_shapes(*collision->geometry, spec.padding)) {
          shape.collider_from_shape = to_pose(collision->origin);
          collider.shapes.push_back(std::move(shape));
        }
      } catch (const InputError& error) {
        ROS_WARN_STREAM_NAMED("robot", "link " << name << ": a collision element is left out: " << error.what());
      }
    }
    if (!collider.shapes.empty()) colliders.push_back(std::move(collider));
  }
  return colliders;
}

}  // namespace deformable_sim
