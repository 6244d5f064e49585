// Trajectories of grasps, from messages.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/scene/grasp_trajectory.h"

namespace deformable_sim {

/// In the world frame. Throws InputError; `what` leads its messages.
GraspTrajectory to_trajectory(const msg::GraspTrajectory& message, const std::string& what, Frames* frames);
std::vector<GraspTrajectory> to_trajectories(const std::vector<msg::GraspTrajectory>& messages, const std::string& what,
                                             Frames* frames);

}  // namespace deformable_sim
