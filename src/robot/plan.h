// A motion as joint positions over time: every pose solved before the robot moves.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "arm.h"
#include "motion.h"

namespace robot_demo {

struct Plan {
  std::vector<std::string> joint_names;
  std::vector<std::vector<double>> positions;  // one row a sample, parallel to joint_names; rad, m
  std::vector<size_t> step_end;                // sample at which each step of the motion is reached
};

/// Inverse kinematics `rate` times a second along the whole motion. Throws std::runtime_error naming the step, the arm
/// and the reason when a pose is out of reach, a joint too fast or a finger beyond its stroke.
Plan make_plan(const Motion& motion, const std::map<std::string, Arm>& arms, const urdf::Model& model, double rate);

}  // namespace robot_demo
