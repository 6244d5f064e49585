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

namespace deformable_sim {
namespace {

// A plane is an fcl::Halfspace (solid below) and never part of an FCL broad phase, which such a shape crashes.
using Geometry = std::variant<fcl::Boxd, fcl::Sphered, fcl::Cylinderd, fcl::Capsuled, fcl::Halfspaced>;

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
    case Shape::Type::kPlane:
      break;
  }
  return fcl::Halfspaced(Vec3::UnitZ(), 0.0);
}

/// Half edges of the box around the shape turned by r.
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
      break;
  }
  return Vec3::Constant(std::numeric_limits<double>::infinity());
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
};

SurfaceQuery::SurfaceQuery(const Shape& shape) : kernel_(std::make_unique<Kernel>(shape)) {
  kernel_->contacts.reserve(4);
  place(shape.collider_from_shape);
}
SurfaceQuery::~SurfaceQuery() = default;
SurfaceQuery::SurfaceQuery(SurfaceQuery&&) noexcept = default;
SurfaceQuery& SurfaceQuery::operator=(SurfaceQuery&&) noexcept = default;

void SurfaceQuery::place(const Pose& world_from_shape) {
  kernel_->world_from_shape = world_from_shape;
  const Vec3 half = half_extent(kernel_->shape, world_from_shape.linear());
  kernel_->box = Eigen::AlignedBox3d(world_from_shape.translation() - half, world_from_shape.translation() + half);
}

bool SurfaceQuery::find(const Vec3& p, double reach, SurfacePoint* found) {
  Kernel& k = *kernel_;
  k.point.radius = reach;
  k.world_from_point.translation() = p;
  k.contacts.clear();
  const bool hit = std::visit(
      [&k](const auto& geometry) {
        return k.solver.shapeIntersect(k.point, k.world_from_point, geometry, k.world_from_shape, &k.contacts);
      },
      k.geometry);
  if (!hit || k.contacts.empty()) return false;
  // FCL's normal points from the first shape, the sphere, into the second.
  found->distance = reach - k.contacts.front().penetration_depth;
  found->normal = -k.contacts.front().normal;
  if (found->normal.squaredNorm() < 0.5) found->normal = k.world_from_shape.linear().col(0);
  return true;
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
