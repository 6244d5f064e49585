// Grasps: which nodes follow which moving frame, and the wrench they report.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// How a grasp finds its nodes; values equal GraspSelection.method.
enum class SelectionMethod { kNearest = 0, kRadius = 1, kBox = 2, kNodes = 3, kFeature = 4 };

struct Selection {
  SelectionMethod method = SelectionMethod::kNearest;
  Pose world_from_selection = Pose::Identity();  // where to look: nearest, radius, box
  double radius = 0.0;                           // m; nearest: how far the node may be, 0 = 0.02
  Vec3 size = Vec3::Zero();                      // m, full edge lengths, box
  std::vector<int> nodes;                        // body-local
  std::string feature;
};

/// What a grasp is asked to be. The grasp frame starts at world_from_grasp; nodes are attached rigidly to it as they
/// lie.
struct GraspRequest {
  std::string name;
  std::string body;
  Selection selection;
  bool has_frame = false;  // world_from_grasp given; otherwise identity rotation at the centroid of the nodes
  Pose world_from_grasp = Pose::Identity();
  double max_force = 0.0;    // N, slips off beyond; 0 = holds always
  double max_speed = 0.0;    // m/s; 0 = the scene's default
  double stiffness = 0.0;    // N/m per grasp; 0 = rigid
  bool points_only = false;  // rods with twist: hold places only, a ball joint; otherwise an end is clamped
  std::string follow_frame;  // kept for reports; the ROS layer drives it
};

/// Values equal GraspState.state.
enum class GraspPhase { kHolding = 0, kSlipped = 1, kWaitingForFrame = 2 };

struct GraspReport {
  std::string name;
  std::string body;
  std::string follow_frame;
  std::vector<int> nodes;  // body-local
  GraspPhase phase = GraspPhase::kHolding;
  Pose world_from_grasp = Pose::Identity();
  Vec3 force = Vec3::Zero();   // N the body exerts on the gripper, world axes
  Vec3 torque = Vec3::Zero();  // N m about the grasp origin, world axes
  double load = 0.0;           // |force| / max_force; 0 when max_force is 0
  bool speed_limited = false;  // the target is being approached at max_speed
};

}  // namespace deformable_sim
