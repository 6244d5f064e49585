// What the arms shall do: Cartesian waypoints with a time, a gripper opening and grasp commands.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <XmlRpcValue.h>
#include <Eigen/Geometry>

#include "deformable_sim/Grasp.h"

namespace robot_demo {

struct ArmSpec {
  std::string tip;                   // link that the waypoints place
  std::vector<std::string> fingers;  // prismatic joints, each moves by half the opening
};

struct Goal {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  double opening = 0.0;  // m, between the fingers
};

struct Step {
  std::string phase;
  double duration = 0.0;                               // s, from the step before
  bool pass = false;                                   // go through without stopping
  std::map<std::string, Goal> goals;                   // of every arm, at the end of the step
  std::vector<deformable_sim::Grasp::Request> grasps;  // asked for at the end of the step
  std::vector<std::string> releases;
};

struct Motion {
  std::string frame;  // of all positions: a link of the robot
  std::map<std::string, ArmSpec> arms;
  std::vector<Step> steps;  // the first one is where the arms start
};

/// Reads the parameter tree of a config/demo file. Throws std::runtime_error saying which step and key is wrong.
Motion read_motion(XmlRpc::XmlRpcValue tree);

/// Where an arm is `s` seconds into step `i`, 0 <= s <= duration: a quintic through the waypoints, at rest at those
/// without `pass`.
Goal interpolate(const Motion& motion, const std::string& arm, size_t i, double s);

}  // namespace robot_demo
