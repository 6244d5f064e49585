// A rigid obstacle as the user gives it: shapes, a pose, friction. No FCL here.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

class ColliderMesh;
class VoxelSolid;

/// One shape in its own frame: box centred, cylinder, capsule and cone (tip up) along z and centred, plane =
/// half-space z <= 0, mesh and voxels where their vertices and cubes are.
struct Shape {
  enum class Type { kBox, kSphere, kCylinder, kCapsule, kPlane, kCone, kMesh, kVoxels };
  Type type = Type::kBox;
  Vec3 size = Vec3::Zero();  // box: full edge lengths; sphere: [radius]; cylinder, capsule: [radius, length of the
                             // straight part]; cone: [radius, length]; mesh: [padding, >= 0]
  std::shared_ptr<const ColliderMesh> mesh;  // of kMesh only
  std::shared_ptr<const VoxelSolid> voxels;  // of kVoxels only
  Pose collider_from_shape = Pose::Identity();
};

/// A rigid body that deformables may not enter. Several shapes move as one.
struct Collider {
  std::string name;
  std::vector<Shape> shapes;
  Pose world_from_collider = Pose::Identity();
  double friction = 0.5;
  std::string frame;  // tf frame it is attached to (moved there by the ROS layer); empty = fixed in the world
  Pose frame_from_collider = Pose::Identity();  // of an attached one; for reports
  std::vector<std::string> lets_through;        // names of bodies that it does not touch
};

/// Throws InputError naming the collider: no name, no shape, a size <= 0 (a capsule's straight part may be 0), a mesh
/// without triangles, voxels without cubes, a pose that is not finite or not rigid, friction negative or not finite.
void check_collider(const Collider& collider);

/// Whether the collider and the body of this name do not touch.
bool lets_through(const Collider& collider, const std::string& body);

/// The same name, frame, friction and shapes.
bool same_but_for_pose(const Collider& a, const Collider& b);

}  // namespace deformable_sim
