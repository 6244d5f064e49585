// Collision shapes of a robot from its URDF.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Colliders of robot links are called this plus the link; no name of a user can contain the dot.
constexpr const char* kRobotPrefix = "robot.";

/// One collider a link that has collision elements, all of them, attached to the link's tf frame, pose =
/// frame_from_collider = identity. Meshes are found by resource_retriever (package://, file://, http://) and scaled as
/// the URDF says. Boxes and cylinders are padded to larger ones with sharp edges, meshes roundly. A mesh that is
/// missing or no closed solid is left out with a warning naming link and file.
/// Throws InputError: text that is no URDF, a link of `spec` that does not exist.
std::vector<Collider> robot_links(const std::string& urdf_xml, const RobotSpec& spec);

}  // namespace deformable_sim
