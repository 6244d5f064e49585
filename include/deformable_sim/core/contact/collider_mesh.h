// A solid bounded by triangles, convex or not: exact signed distance, and planes that keep a point out of it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/distance_grid.h"
#include "deformable_sim/core/contact/solid_parts.h"
#include "deformable_sim/core/contact/triangle_tree.h"

namespace deformable_sim {

/// Nearest surface point of a mesh, in the mesh's frame.
struct MeshPoint {
  double distance = 0.0;        // m, negative inside
  Vec3 normal = Vec3::UnitZ();  // unit, outwards; the nearest point is p - distance * normal
  int triangle = -1;
};

struct MeshBuild {
  std::string cache_folder;  // of finished distance grids; empty = none is kept
  DistanceGrid::Progress progress;
};

/// Immutable, to be shared by shapes, snapshots and threads.
///
/// The distance is that to the nearest triangle, found in a tree of boxes; its sign that of (p - q) . n with the
/// pseudonormal n of the face, edge or vertex q lies on: the faces around it, those at a vertex weighted by their
/// angles [Baerentzen & Aanaes 2005], which is right for every closed surface. A grid of distances answers first, and
/// where it proves the surface out of reach that is all.
class ColliderMesh {
 public:
  explicit ColliderMesh(SolidPart part, const MeshBuild& build = {});

  const SolidPart& part() const { return part_; }
  const std::vector<Vec3>& vertices() const { return part_.vertices; }
  const std::vector<std::array<int, 3>>& triangles() const { return part_.triangles; }
  const Eigen::AlignedBox3d& box() const { return box_; }
  /// Around the origin of the mesh's frame, m.
  double bounding_radius() const { return radius_; }
  /// No vertex lies in front of a face by more than a millionth of the size: one tangent plane separates.
  bool convex() const { return convex_; }
  const DistanceGrid& grid() const { return grid_; }

  /// False when the surface is further than `reach` (m, >= 0) outside.
  bool nearest(const Vec3& p, double reach, MeshPoint* found) const;

  /// Planes through the nearest points of all triangles within `reach` of p, each with its triangle below it, in the
  /// order of triangle numbers; distances are those of p. A point that goes from p straight to where it is `clearance`
  /// (m, >= 0) or more above all of them goes through no triangle within reach: it stays outside.
  ///
  /// A triangle is left out when the plane of a nearer one has it below as well, or so little above that neither p nor
  /// a point with that clearance comes there. `padding` (m, >= 0) moves the surface outwards. `surface` is what
  /// nearest() found at p, padding taken off. When that is inside, or another way out of the solid is to be taken, the
  /// planes are those of the point a little above the surface there. Appends to `planes`; `work` is scratch space.
  void planes(const Vec3& p, const MeshPoint& surface, double reach, double clearance, double padding,
              std::vector<TrianglePoint>* work, std::vector<MeshPoint>* planes) const;

 private:
  bool exact(const Vec3& p, double reach, MeshPoint* found) const;
  Vec3 pseudonormal(int triangle, TriangleFeature feature) const;
  MeshPoint at(const Vec3& p, const TrianglePoint& nearest) const;
  void gather(const Vec3& p, double reach, double clearance, double padding, std::vector<TrianglePoint>* work,
              std::vector<MeshPoint>* planes) const;
  double height_above(const Vec3& p, const MeshPoint& plane, int triangle) const;
  bool is_convex() const;
  void fill_grid(const DistanceGrid::Progress& progress);

  SolidPart part_;
  std::vector<Vec3> face_normals_, vertex_normals_;  // unit
  Eigen::AlignedBox3d box_;
  double radius_ = 0.0;
  double least_ = 0.0;  // m, below which a direction is not taken from a distance
  bool convex_ = false;
  TriangleTree tree_;
  DistanceGrid grid_;
};

/// One for each closed part of the mesh (split_into_solids() tells which meshes are refused).
std::vector<std::shared_ptr<const ColliderMesh>> make_collider_meshes(const TriangleMesh& mesh,
                                                                      const MeshBuild& build = {});

}  // namespace deformable_sim
