// A solid made of cubes on a grid, as occupancy maps have them: exact signed distance, and planes that keep a point
// out.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deformable_sim/core/contact/collider_mesh.h"

namespace deformable_sim {

/// Cells key ... key + 2^level - 1 along each axis. A multiple of 2^level in each coordinate; the frame's origin is
/// where cell kVoxelOrigin begins, as in OctoMap.
struct VoxelCube {
  std::array<std::uint16_t, 3> key{{0, 0, 0}};
  int level = 0;  // 0 ... kVoxelLevels
};

constexpr int kVoxelLevels = 16;
constexpr int kVoxelOrigin = 32768;
constexpr int kMostVoxelCubes = 500000;

/// A square of the surface, in cells from the frame's origin.
struct VoxelSquare {
  std::array<int, 3> corner{{0, 0, 0}};  // the lowest
  int size = 1;
  int axis = 0;      // it is normal to
  int outwards = 1;  // +1 or -1 along the axis
};

/// Where on the surface a point is near; all in cells.
struct SquarePoint {
  Vec3 point = Vec3::Zero();
  double squared_distance = 0.0;
  int square = -1;
};

/// The union of the cubes, immutable, to be shared by shapes, snapshots and threads.
///
/// Only faces between a cube and free space bound it: the surface is cut into squares, a large face beside small cubes
/// into as many as it takes. The distance is that to the nearest square, found in a tree of boxes; its sign that of the
/// cell the point is in. So cubes that meet in an edge or a corner only are nothing special, and nothing catches where
/// cubes lie side by side.
///
/// Not good at: slopes, which are stairs as high as the cubes are.
class VoxelSolid {
 public:
  /// resolution: m, edge of a cell. The cubes must not overlap. Throws InputError: no cube, more than kMostVoxelCubes
  /// (kOutOfRange), a key that is no multiple of its cube's size, a resolution that is not 1e-4 ... 100 m.
  VoxelSolid(std::vector<VoxelCube> cubes, double resolution);

  double resolution() const { return resolution_; }
  /// Sorted along the Morton curve.
  const std::vector<VoxelCube>& cubes() const { return cubes_; }
  const std::vector<VoxelSquare>& squares() const { return squares_; }
  const Eigen::AlignedBox3d& box() const { return box_; }
  /// Around the origin of the map's frame, m.
  double bounding_radius() const { return radius_; }

  bool occupied(const Vec3& p) const;
  /// False when the surface is further than `reach` (m, >= 0) outside. MeshPoint::triangle is the square's number.
  bool nearest(const Vec3& p, double reach, MeshPoint* found) const;
  /// As ColliderMesh::planes(), with a plane for a square, and without padding.
  void planes(const Vec3& p, const MeshPoint& surface, double reach, double clearance, std::vector<SquarePoint>* work,
              std::vector<MeshPoint>* planes) const;

 private:
  enum class Cover { kNone, kSome, kAll };
  /// Squares first ... first + count - 1 when count > 0, else children at the next node and at `right`.
  struct Node {
    std::array<int, 3> low, high;
    int first = 0, count = 0, right = 0;
  };

  Cover cover(const std::array<int, 3>& key, int level) const;
  void add_face(const std::array<int, 3>& key, int level, int axis, int outwards);
  int add_node(int first, int last);
  // Of points and lengths in cells.
  bool occupied_cell(const Vec3& p) const;
  bool exact(const Vec3& p, double reach, MeshPoint* found) const;
  void descend(int node, const Vec3& p, SquarePoint* best) const;
  void within(int node, const Vec3& p, double squared_reach, std::vector<SquarePoint>* found) const;
  MeshPoint facing(const Vec3& p, const SquarePoint& nearest) const;
  void gather(const Vec3& p, double reach, double clearance, std::vector<SquarePoint>* work,
              std::vector<MeshPoint>* planes) const;

  double resolution_;
  std::vector<VoxelCube> cubes_;
  std::vector<std::uint64_t> first_cell_;  // of each cube, on the Morton curve
  std::vector<VoxelSquare> squares_;
  std::vector<Node> nodes_;
  Eigen::AlignedBox3d box_;
  double radius_ = 0.0;
  double least_ = 0.0;  // cells, below which a direction is not taken from a distance
};

}  // namespace deformable_sim
