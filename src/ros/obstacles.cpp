#include "deformable_sim/ros/obstacles.h"

#include <algorithm>

#include "deformable_sim/core/contact/solid_parts.h"
#include "deformable_sim/ros/build_progress.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/network_files.h"
#include "deformable_sim/scene/collider_file.h"
#include "deformable_sim/scene/octomap_file.h"

namespace deformable_sim {

namespace {

constexpr std::size_t kMostShapes = 1000;

Shape to_shape(const shape_msgs::SolidPrimitive& primitive) {
  using Primitive = shape_msgs::SolidPrimitive;
  Shape shape;
  std::size_t dimensions = 2;
  switch (primitive.type) {
    case Primitive::BOX:
      shape.type = Shape::Type::kBox;
      dimensions = 3;
      break;
    case Primitive::SPHERE:
      shape.type = Shape::Type::kSphere;
      dimensions = 1;
      break;
    case Primitive::CYLINDER:
      shape.type = Shape::Type::kCylinder;
      break;
    case Primitive::CONE:
      shape.type = Shape::Type::kCone;
      break;
    case msg::Obstacle::CAPSULE:
      shape.type = Shape::Type::kCapsule;
      break;
    default:
      throw InputError("primitives.type: " + std::to_string(primitive.type) +
                       ", allowed are BOX 1, SPHERE 2, CYLINDER 3, CONE 4, CAPSULE " +
                       std::to_string(msg::Obstacle::CAPSULE));
  }
  if (primitive.dimensions.size() != dimensions) {
    throw InputError("primitives.dimensions: " + std::to_string(primitive.dimensions.size()) +
                     " given, this type has " + std::to_string(dimensions));
  }
  for (const double d : primitive.dimensions) to_non_negative(d, "primitives.dimensions");
  if (dimensions == 2) {  // messages say height, radius
    shape.size = Vec3(primitive.dimensions[1], primitive.dimensions[0], 0);
  } else {
    for (std::size_t i = 0; i < dimensions; ++i) shape.size[i] = primitive.dimensions[i];
  }
  return shape;
}

/// Frame of a plane: z along its normal, origin at the point nearest to the frame's.
Pose to_pose(const shape_msgs::Plane& plane) {
  const Vec3 normal(plane.coef[0], plane.coef[1], plane.coef[2]);
  const double length = normal.norm();
  if (!normal.allFinite() || !std::isfinite(plane.coef[3]) || length < 1e-9) {
    throw InputError("planes: coefficients must be finite and the normal not zero");
  }
  const Vec3 n = normal / length;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), n).toRotationMatrix();
  pose.translation() = -plane.coef[3] / length * n;
  return pose;
}

std::vector<Shape> to_shapes(const shape_msgs::Mesh& m, const std::string& name, std::size_t number) {
  const std::string who = "meshes[" + std::to_string(number) + "]: ";
  if (m.triangles.size() > static_cast<std::size_t>(kMostColliderTriangles) ||
      m.vertices.size() > 3 * static_cast<std::size_t>(kMostColliderTriangles)) {
    throw InputError(who + std::to_string(m.triangles.size()) + " triangles and " + std::to_string(m.vertices.size()) +
                         " vertices, at most " + std::to_string(kMostColliderTriangles) + " triangles are allowed",
                     Code::kOutOfRange);
  }
  TriangleMesh mesh;
  mesh.rest.resize(3, static_cast<Eigen::Index>(m.vertices.size()));
  for (std::size_t i = 0; i < m.vertices.size(); ++i) {
    mesh.rest.col(static_cast<Eigen::Index>(i)) << m.vertices[i].x, m.vertices[i].y, m.vertices[i].z;
  }
  for (const shape_msgs::MeshTriangle& t : m.triangles) {
    std::array<int, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      // An index beyond all vertices stays one.
      corners[k] = static_cast<int>(std::min<std::size_t>(t.vertex_indices[k], m.vertices.size()));
    }
    mesh.triangles.push_back(corners);
  }
  try {
    return mesh_shapes(mesh, 0.0, build_progress(name));
  } catch (const InputError& error) {
    throw InputError(who + error.what(), error.code());
  }
}

Shape to_shape(const msg::Octomap& m, std::size_t number, const AllowedPaths& files) {
  const std::string who = "octomaps[" + std::to_string(number) + "]";
  try {
    if (!m.file.empty()) return load_octomap(path_of_url(m.file, files));
    return octomap_shape({m.binary != 0, m.id, m.resolution, std::string(m.data.begin(), m.data.end())});
  } catch (const InputError& error) {
    throw InputError(who + ": " + error.what(), error.code());
  }
}

void check_sizes(const msg::Obstacle& m) {
  const std::size_t shapes = m.primitives.size() + m.meshes.size() + m.planes.size() + m.octomaps.size();
  if (shapes > kMostShapes) {
    throw InputError(
        "primitives: " + std::to_string(shapes) + " shapes, at most " + std::to_string(kMostShapes) + " are allowed",
        Code::kOutOfRange);
  }
}

}  // namespace

ObstacleRequest to_obstacle(const msg::Obstacle& m, const AllowedPaths& files, Frames* frames) {
  check_name("name", m.name);
  check_sizes(m);
  if (m.primitives.size() != m.primitive_poses.size()) {
    throw InputError("primitive_poses: " + std::to_string(m.primitive_poses.size()) + " for " +
                     std::to_string(m.primitives.size()) + " primitives, one for each is needed");
  }
  if (m.meshes.size() != m.mesh_poses.size()) {
    throw InputError("mesh_poses: " + std::to_string(m.mesh_poses.size()) + " for " + std::to_string(m.meshes.size()) +
                     " meshes, one for each is needed");
  }
  if (m.octomaps.size() != m.octomap_poses.size()) {
    throw InputError("octomap_poses: " + std::to_string(m.octomap_poses.size()) + " for " +
                     std::to_string(m.octomaps.size()) + " octomaps, one for each is needed");
  }
  if (m.primitives.empty() && m.meshes.empty() && m.planes.empty() && m.octomaps.empty())
    throw InputError("primitives: none, no mesh, no plane and no octomap; an obstacle needs a shape");

  ObstacleRequest request;
  Collider& collider = request.collider;
  collider.name = m.name;
  collider.friction = to_non_negative(m.friction, "friction");
  collider.frame = m.frame;
  collider.lets_through = m.lets_through;
  std::vector<Pose> poses;  // in header.frame_id
  for (std::size_t i = 0; i < m.primitives.size(); ++i) {
    collider.shapes.push_back(to_shape(m.primitives[i]));
    poses.push_back(to_pose(m.primitive_poses[i], "primitive_poses"));
  }
  for (std::size_t i = 0; i < m.meshes.size(); ++i) {
    const Pose pose = to_pose(m.mesh_poses[i], "mesh_poses");
    for (Shape& shape : to_shapes(m.meshes[i], m.name, i)) {
      collider.shapes.push_back(std::move(shape));
      poses.push_back(pose);
    }
  }
  for (const shape_msgs::Plane& plane : m.planes) {
    Shape shape;
    shape.type = Shape::Type::kPlane;
    collider.shapes.push_back(shape);
    poses.push_back(to_pose(plane));
  }
  for (std::size_t i = 0; i < m.octomaps.size(); ++i) {
    collider.shapes.push_back(to_shape(m.octomaps[i], i, files));
    poses.push_back(to_pose(m.octomap_poses[i], "octomap_poses"));
  }
  for (std::size_t i = 0; i < poses.size(); ++i) collider.shapes[i].collider_from_shape = poses[0].inverse() * poses[i];
  collider.world_from_collider = frames->resolve(m.header.frame_id) * poses[0];
  if (!m.frame.empty()) {
    request.frame_from_collider = frames->resolve(m.frame).inverse() * collider.world_from_collider;
  }
  return request;
}

command::MoveCollider to_obstacle_move(const msg::Obstacle& m, Frames* frames) {
  check_name("name", m.name);
  if (m.primitive_poses.empty() && m.mesh_poses.empty() && m.planes.empty() && m.octomap_poses.empty()) {
    throw InputError(
        "primitive_poses: empty; MOVE needs the new pose of the first primitive (else of the first mesh, else the "
        "first plane, else of the first octomap)");
  }
  const Pose pose = !m.primitive_poses.empty() ? to_pose(m.primitive_poses[0], "primitive_poses")
                    : !m.mesh_poses.empty()    ? to_pose(m.mesh_poses[0], "mesh_poses")
                    : !m.planes.empty()        ? to_pose(m.planes[0])
                                               : to_pose(m.octomap_poses[0], "octomap_poses");
  return {m.name, frames->resolve(m.header.frame_id) * pose, 0.0};
}

}  // namespace deformable_sim
