#include "deformable_sim/ros/rigid_drawing.h"

#include <cmath>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/voxel_solid.h"
#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

using visualization_msgs::Marker;

constexpr double kPlaneThickness = 0.002;  // m
constexpr int kConeSides = 32;
constexpr double kBall = 0.02;    // m
constexpr double kLetter = 0.03;  // m
constexpr std::array<float, 3> kSolid{{0.70f, 0.73f, 0.77f}};

Marker solid(int type, const Pose& pose, const Vec3& size, const std::array<float, 3>& color) {
  Marker marker;
  marker.type = type;
  marker.pose = to_message(pose);
  marker.scale = to_vector(size);
  marker.color.r = color[0];
  marker.color.g = color[1];
  marker.color.b = color[2];
  marker.color.a = 1.0f;
  return marker;
}

void add_triangle(const Vec3& a, const Vec3& b, const Vec3& c, Marker* marker) {
  for (const Vec3* p : {&a, &b, &c}) {
    geometry_msgs::Point point;
    point.x = p->x();
    point.y = p->y();
    point.z = p->z();
    marker->points.push_back(point);
  }
}

Marker cone(double radius, double length, const Pose& pose) {
  Marker marker = solid(Marker::TRIANGLE_LIST, pose, Vec3::Ones(), kSolid);
  const Vec3 tip(0, 0, 0.5 * length), base(0, 0, -0.5 * length);
  const auto rim = [&](int k) -> Vec3 {
    const double angle = 2.0 * M_PI * k / kConeSides;
    return base + radius * Vec3(std::cos(angle), std::sin(angle), 0.0);
  };
  for (int k = 0; k < kConeSides; ++k) {
    add_triangle(rim(k), rim(k + 1), tip, &marker);
    add_triangle(rim(k + 1), rim(k), base, &marker);
  }
  return marker;
}

Marker mesh_marker(const ColliderMesh& mesh, const Pose& pose) {
  Marker marker = solid(Marker::TRIANGLE_LIST, pose, Vec3::Ones(), kSolid);
  marker.points.reserve(3 * mesh.triangles().size());
  const auto vertex = [&mesh](int k) -> const Vec3& { return mesh.vertices()[static_cast<std::size_t>(k)]; };
  for (const std::array<int, 3>& t : mesh.triangles()) add_triangle(vertex(t[0]), vertex(t[1]), vertex(t[2]), &marker);
  return marker;
}

/// One list of cubes for each size.
void add_voxels(const VoxelSolid& solid_of_voxels, const Pose& pose, std::vector<Marker>* markers) {
  for (int level = 0; level <= kVoxelLevels; ++level) {
    const double size = solid_of_voxels.resolution() * (1 << level);
    Marker marker = solid(Marker::CUBE_LIST, pose, Vec3::Constant(size), kSolid);
    for (const VoxelCube& cube : solid_of_voxels.cubes()) {
      if (cube.level != level) continue;
      geometry_msgs::Point point;
      point.x = solid_of_voxels.resolution() * (cube.key[0] - kVoxelOrigin) + 0.5 * size;
      point.y = solid_of_voxels.resolution() * (cube.key[1] - kVoxelOrigin) + 0.5 * size;
      point.z = solid_of_voxels.resolution() * (cube.key[2] - kVoxelOrigin) + 0.5 * size;
      marker.points.push_back(point);
    }
    if (!marker.points.empty()) markers->push_back(std::move(marker));
  }
}

void add_shape(const Shape& shape, const Pose& pose, std::vector<Marker>* markers) {
  const double diameter = 2.0 * shape.size.x();
  const Vec3 round(diameter, diameter, diameter);
  const auto shifted = [&](double z) -> Pose { return pose * Eigen::Translation3d(0, 0, z); };
  switch (shape.type) {
    case Shape::Type::kBox:
      markers->push_back(solid(Marker::CUBE, pose, shape.size, kSolid));
      break;
    case Shape::Type::kSphere:
      markers->push_back(solid(Marker::SPHERE, pose, round, kSolid));
      break;
    case Shape::Type::kCapsule:
      markers->push_back(solid(Marker::SPHERE, shifted(0.5 * shape.size.y()), round, kSolid));
      markers->push_back(solid(Marker::SPHERE, shifted(-0.5 * shape.size.y()), round, kSolid));
      [[fallthrough]];
    case Shape::Type::kCylinder:
      markers->push_back(solid(Marker::CYLINDER, pose, Vec3(diameter, diameter, shape.size.y()), kSolid));
      break;
    case Shape::Type::kCone:
      markers->push_back(cone(shape.size.x(), shape.size.y(), pose));
      break;
    case Shape::Type::kMesh:
      markers->push_back(mesh_marker(*shape.mesh, pose));
      break;
    case Shape::Type::kVoxels:
      add_voxels(*shape.voxels, pose, markers);
      break;
    case Shape::Type::kPlane:
      markers->push_back(solid(Marker::CUBE, shifted(-0.5 * kPlaneThickness),
                               Vec3(kPlaneSize, kPlaneSize, kPlaneThickness), {{0.75f, 0.75f, 0.72f}}));
      break;
  }
}

void number(const std::string& ns, std::vector<Marker>* markers) {
  for (std::size_t i = 0; i < markers->size(); ++i) {
    (*markers)[i].ns = ns;
    (*markers)[i].id = static_cast<int>(i);
  }
}

std::array<float, 3> color_of(GraspPhase phase) {
  switch (phase) {
    case GraspPhase::kHolding:
      return {{0.15f, 0.75f, 0.25f}};
    case GraspPhase::kSlipped:
      return {{0.85f, 0.15f, 0.1f}};
    case GraspPhase::kWaitingForFrame:
      return {{0.95f, 0.6f, 0.1f}};
  }
  return {{1, 1, 1}};
}

}  // namespace

std::vector<Marker> collider_markers(const Collider& collider) {
  std::vector<Marker> markers;
  for (const Shape& shape : collider.shapes) {
    add_shape(shape, collider.world_from_collider * shape.collider_from_shape, &markers);
  }
  number("collider/" + collider.name, &markers);
  return markers;
}

std::vector<Marker> grasp_markers(const GraspReport& grasp) {
  Pose above = Pose::Identity();
  above.translation() = grasp.world_from_grasp.translation() + Vec3(0, 0, 2.0 * kBall);
  std::vector<Marker> markers{
      solid(Marker::SPHERE, grasp.world_from_grasp, Vec3(kBall, kBall, kBall), color_of(grasp.phase)),
      solid(Marker::TEXT_VIEW_FACING, above, Vec3(0, 0, kLetter), kLetterColor)};
  markers[1].text = grasp.name;
  number("grasp/" + grasp.name, &markers);
  return markers;
}

}  // namespace deformable_sim
