// Collision shapes of a robot from its URDF.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Colliders of robot links are called this plus the link; no name of a user can contain the dot.
constexpr const char* kRobotPrefix = "robot.";

/// One collider a link that has box, sphere or cylinder collision shapes, attached to the link's tf frame, pose =
/// frame_from_collider = identity. Collision meshes are left out with a warning naming the link.
/// Throws InputError: text that is no URDF, a link of `spec` that does not exist.
std::vector<Collider> robot_links(const std::string& urdf_xml, const RobotSpec& spec);

}  // namespace deformable_sim
