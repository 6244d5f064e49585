// Grasp messages to core requests, frames resolved.
#pragma once

#include <string>
#include <vector>

#include <geometry_msgs/PoseStamped.h>

#include "deformable_sim/core/command.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/messages.h"

namespace deformable_sim {

/// World pose of a target in any tf frame, newest transform; frame_id empty = world frame. Throws InputError.
Pose to_world_pose(const geometry_msgs::PoseStamped& pose, const std::string& what, Frames* frames);

/// What Grasp.srv and GraspCommand have in common, by the same field names. Throws InputError: name, numbers, frames.
command::Grasp to_grasp(const std::string& name, const std::string& body, const msg::GraspSelection& selection,
                        const std::string& follow_frame, double max_force, double max_speed, double stiffness,
                        Frames* frames);

/// One command, or two for a GRASP with a first target. Throws InputError.
std::vector<Command> to_commands(const msg::GraspCommand& message, Frames* frames);

}  // namespace deformable_sim
