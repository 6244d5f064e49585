// The few types every layer shares.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deformable_sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// One column per node: positions (m), velocities (m/s) or forces (N).
using Nodes = Eigen::Matrix3Xd;
/// Rigid transform, named target_from_source.
using Pose = Eigen::Isometry3d;

}  // namespace deformable_sim
