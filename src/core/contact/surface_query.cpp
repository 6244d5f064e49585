#include "deformable_sim/core/contact/surface_query.h"

#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/detail/gjk_solver_libccd.h>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/cone_distance.h"
#include "deformable_sim/core/contact/voxel_solid.h"

namespace deformable_sim {
namespace {

// A plane is an fcl::Halfspace (solid below) and never part of an FCL broad phase, which such a shape crashes.
// Cones, meshes and voxels are answered for without FCL's narrow phase, which is wrong about them.
struct Cone {
  double radius, length;
};
struct Mesh {
  std::shared_ptr<const ColliderMesh> mesh;
  double padding;
};
struct Voxels {
  std::shared_ptr<const VoxelSolid> solid;
};
using Geometry =
    std::variant<fcl::Boxd, fcl::Sphered, fcl::Cylinderd, fcl::Capsuled, fcl::Halfspaced, Cone, Mesh, Voxels>;

Geometry make_geometry(const Shape& shape) {
  switch (shape.type) {
    case Shape::Type::kBox:
      return fcl::Boxd(shape.size);
    case Shape::Type::kSphere:
      return fcl::Sphered(shape.size[0]);
    case Shape::Type::kCylinder:
      return fcl::Cylinderd(shape.size[0], shape.size[1]);
    case Shape::Type::kCapsule:
      return fcl::Capsuled(shape.size[0], shape.size[1]);
    case Shape::Type::kCone:
      return Cone{shape.size[0], shape.size[1]};
    case Shape::Type::kMesh:
      return Mesh{shape.mesh, shape.size[0]};
    case Shape::Type::kVoxels:
      return Voxels{shape.voxels};
    case Shape::Type::kPlane:
      break;
  }
  return fcl::Halfspaced(Vec3::UnitZ(), 0.0);
}

/// Half edges of the box around the shape turned by r; the box is centred on the shape's origin.
Vec3 half_extent(const Shape& shape, const Mat3& r) {
  const Vec3 axis = r.col(2);
  switch (shape.type) {
    case Shape::Type::kBox:
      return r.cwiseAbs() * (0.5 * shape.size);
    case Shape::Type::kSphere:
      return Vec3::Constant(shape.size[0]);
    case Shape::Type::kCylinder:
      return 0.5 * shape.size[1] * axis.cwiseAbs() +
             shape.size[0] * (Vec3::Ones() - axis.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
    case Shape::Type::kCapsule:
      return 0.5 * shape.size[1] * axis.cwiseAbs() + Vec3::Constant(shape.size[0]);
    case Shape::Type::kPlane:
    case Shape::Type::kCone:
    case Shape::Type::kMesh:
    case Shape::Type::kVoxels:
      break;
  }
  return Vec3::Constant(std::numeric_limits<double>::infinity());
}

/// Around the base and the tip.
Eigen::AlignedBox3d cone_box(const Shape& cone, const Pose& pose) {
  const Vec3 axis = pose.linear().col(2);
  const Vec3 base = pose.translation() - 0.5 * cone.size[1] * axis;
  const Vec3 half = cone.size[0] * (Vec3::Ones() - axis.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  Eigen::AlignedBox3d box(base - half, base + half);
  return box.extend(pose.translation() + 0.5 * cone.size[1] * axis);
}

/// Around the turned box of a mesh or of voxels: tight as long as it is not turned.
Eigen::AlignedBox3d turned_box(const Eigen::AlignedBox3d& box, double padding, const Pose& pose) {
  const Vec3 center = pose * box.center();
  const Vec3 half = pose.linear().cwiseAbs() * (0.5 * box.sizes()) + Vec3::Constant(padding);
  return Eigen::AlignedBox3d(center - half, center + half);
}

}  // namespace

double bounding_radius(const Shape& shape) {
  switch (shape.type) {
    case Shape::Type::kBox:
      return 0.5 * shape.size.norm();
    case Shape::Type::kSphere:
      return shape.size[0];
    case Shape::Type::kCylinder:
      return std::hypot(shape.size[0], 0.5 * shape.size[1]);
    case Shape::Type::kCapsule:
      return shape.size[0] + 0.5 * shape.size[1];
    case Shape::Type::kCone:
      return std::hypot(shape.size[0], 0.5 * shape.size[1]);
    case Shape::Type::kMesh:
      return shape.mesh->bounding_radius() + shape.size[0];
    case Shape::Type::kVoxels:
      return shape.voxels->bounding_radius();
    case Shape::Type::kPlane:
      break;
  }
  return 0.0;
}

struct SurfaceQuery::Kernel {
  explicit Kernel(const Shape& s) : shape(s), geometry(make_geometry(s)) {}

  Shape shape;
  Geometry geometry;
  Pose world_from_shape = Pose::Identity();
  Eigen::AlignedBox3d box;
  fcl::Sphered point{0.0};
  fcl::Transform3d world_from_point = fcl::Transform3d::Identity();
  std::vector<fcl::ContactPointd> contacts;
  fcl::detail::GJKSolver_libccdd solver;
  std::vector<TrianglePoint> triangles;
  std::vector<SquarePoint> squares;
  std::vector<MeshPoint> mesh_planes;
  std::vector<SurfacePlane> planes;

  bool find(const Cone& cone, double reach, SurfacePoint* found) {
    *found = cone_distance(world_from_shape.inverse() * world_from_point.translation(), cone.radius, cone.length);
    found->normal = world_from_shape.linear() * found->normal;
    return found->distance <= reach;
  }
  bool find(const Mesh& mesh, double reach, SurfacePoint* found) {
    MeshPoint nearest;
    const Vec3 p = world_from_shape.inverse() * world_from_point.translation();
    if (!mesh.mesh->nearest(p, reach + mesh.padding, &nearest)) return false;
    found->distance = nearest.distance - mesh.padding;
    found->normal = world_from_shape.linear() * nearest.normal;
    return true;
  }
  bool find(const Voxels& voxels, double reach, SurfacePoint* found) {
    MeshPoint nearest;
    if (!voxels.solid->nearest(world_from_shape.inverse() * world_from_point.translation(), reach, &nearest))
      return false;
    found->distance = nearest.distance;
    found->normal = world_from_shape.linear() * nearest.normal;
    return true;
  }
  template <typename Primitive>
  bool find(const Primitive& primitive, double reach, SurfacePoint* found) {
    contacts.clear();
    const bool hit = solver.shapeIntersect(point, world_from_point, primitive, world_from_shape, &contacts);
    if (!hit || contacts.empty()) return false;
    // FCL's normal points from the first shape, the sphere, into the second.
    found->distance = reach - contacts.front().penetration_depth;
    found->normal = -contacts.front().normal;
    if (found->normal.squaredNorm() < 0.5) found->normal = world_from_shape.linear().col(0);
    return true;
  }
};

SurfaceQuery::SurfaceQuery(const Shape& shape) : kernel_(std::make_unique<Kernel>(shape)) {
  kernel_->contacts.reserve(4);
  place(shape.collider_from_shape);
}
SurfaceQuery::~SurfaceQuery() = default;
SurfaceQuery::SurfaceQuery(SurfaceQuery&&) noexcept = default;
SurfaceQuery& SurfaceQuery::operator=(SurfaceQuery&&) noexcept = default;

void SurfaceQuery::place(const Pose& world_from_shape) {
  Kernel& k = *kernel_;
  k.world_from_shape = world_from_shape;
  if (const auto* mesh = std::get_if<Mesh>(&k.geometry)) {
    k.box = turned_box(mesh->mesh->box(), mesh->padding, world_from_shape);
    return;
  }
  if (const auto* voxels = std::get_if<Voxels>(&k.geometry)) {
    k.box = turned_box(voxels->solid->box(), 0.0, world_from_shape);
    return;
  }
  if (k.shape.type == Shape::Type::kCone) {
    k.box = cone_box(k.shape, world_from_shape);
    return;
  }
  const Vec3 half = half_extent(k.shape, world_from_shape.linear());
  k.box = Eigen::AlignedBox3d(world_from_shape.translation() - half, world_from_shape.translation() + half);
}

bool SurfaceQuery::find(const Vec3& p, double reach, SurfacePoint* found) {
  Kernel& k = *kernel_;
  k.point.radius = reach;
  k.world_from_point.translation() = p;
  return std::visit([&](const auto& geometry) { return k.find(geometry, reach, found); }, k.geometry);
}

int SurfaceQuery::concave_pieces() const {
  if (const auto* voxels = std::get_if<Voxels>(&kernel_->geometry))
    return static_cast<int>(voxels->solid->squares().size());
  const auto* mesh = std::get_if<Mesh>(&kernel_->geometry);
  return mesh && !mesh->mesh->convex() ? static_cast<int>(mesh->mesh->triangles().size()) : 0;
}

const std::vector<SurfacePlane>& SurfaceQuery::planes(const Vec3& p, const SurfacePoint& nearest, double reach,
                                                      double clearance) {
  Kernel& k = *kernel_;
  const Mat3 shape_from_world = k.world_from_shape.linear().transpose();
  MeshPoint surface;
  surface.distance = nearest.distance;
  surface.normal = shape_from_world * nearest.normal;
  k.mesh_planes.clear();
  k.planes.clear();
  const Vec3 in_shape = k.world_from_shape.inverse() * p;
  if (const auto* voxels = std::get_if<Voxels>(&k.geometry)) {
    voxels->solid->planes(in_shape, surface, reach, clearance, &k.squares, &k.mesh_planes);
  } else {
    const Mesh& mesh = std::get<Mesh>(k.geometry);
    mesh.mesh->planes(in_shape, surface, reach, clearance, mesh.padding, &k.triangles, &k.mesh_planes);
  }
  for (const MeshPoint& plane : k.mesh_planes)
    k.planes.push_back({{plane.distance, k.world_from_shape.linear() * plane.normal}, plane.triangle});
  return k.planes;
}

bool SurfaceQuery::bounded() const {
  return kernel_->shape.type != Shape::Type::kPlane;
}
const Eigen::AlignedBox3d& SurfaceQuery::box() const {
  return kernel_->box;
}
double SurfaceQuery::bounding_radius() const {
  return deformable_sim::bounding_radius(kernel_->shape);
}

}  // namespace deformable_sim
