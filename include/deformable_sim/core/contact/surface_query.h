// The wall around FCL: signed distance and outward normal from a point to one shape. No FCL type in this header.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/contact/collider.h"

namespace deformable_sim {

struct SurfacePoint {
  double distance = 0.0;        // m, negative inside
  Vec3 normal = Vec3::UnitZ();  // unit, out of the shape; nearest surface point = p - distance * normal
};

/// A plane of a mesh or of voxels, and the number of the triangle or square it is for.
struct SurfacePlane {
  SurfacePoint surface;
  int triangle = 0;
};

/// One placed shape. The distance to a primitive comes from FCL's closed-form sphere kernels: a sphere of radius
/// `reach` around the point overlaps the shape by `depth`, so distance = reach - depth, exact inside and out. That to a
/// cone (cone_distance.h), to a mesh (collider_mesh.h) and to voxels (voxel_solid.h) is exact too.
/// Not for concurrent use: it reuses its work space.
class SurfaceQuery {
 public:
  explicit SurfaceQuery(const Shape& shape);
  ~SurfaceQuery();
  SurfaceQuery(SurfaceQuery&&) noexcept;
  SurfaceQuery& operator=(SurfaceQuery&&) noexcept;

  void place(const Pose& world_from_shape);
  /// False when the surface is further than `reach` (m, >= 0) outside. At the centre of a sphere and on the axis of a
  /// capsule, where no direction is nearest, the normal is the shape's +x.
  bool find(const Vec3& p, double reach, SurfacePoint* found);

  /// Triangles of a mesh that is not convex, squares of voxels: a point needs planes() there, one for each at most; 0
  /// where the tangent plane at the nearest point separates.
  int concave_pieces() const;
  /// Of such a shape: planes that together keep p from entering it, in the order of their pieces. `nearest` is what
  /// find() told, or another surface point that p, inside, is to come out at. `clearance` (m): how far p is kept from
  /// the surface. Valid until the next call.
  const std::vector<SurfacePlane>& planes(const Vec3& p, const SurfacePoint& nearest, double reach, double clearance);

  /// False for a plane, which is not in any box.
  bool bounded() const;
  /// Tight box around the placed shape (FCL's own is the cube around the bounding sphere once a shape is turned).
  const Eigen::AlignedBox3d& box() const;
  /// Radius around the shape's origin that contains it, m; 0 for a plane.
  double bounding_radius() const;

 private:
  struct Kernel;
  std::unique_ptr<Kernel> kernel_;
};

/// Radius around the shape's origin that contains it, m; 0 for a plane.
double bounding_radius(const Shape& shape);

}  // namespace deformable_sim
