// What clients may ask for, by topic and by service: convert, hand to the simulation, answer.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <ros/node_handle.h>

#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/rollouts.h"
#include "deformable_sim/ros/saved_states.h"
#include "deformable_sim/ros/scene_changes.h"
#include "deformable_sim/ros/simulation.h"
#include "deformable_sim/ros/warnings.h"

namespace deformable_sim {

/// ~grasp_command, ~grasp/<name>/target, ~obstacle. A refusal has nobody to answer to: it is logged, at most once a
/// second, and listed in ~status.
class CommandTopics {
 public:
  CommandTopics(const ros::NodeHandle& private_nh, Simulation* simulation, Frames* frames, Warnings* warnings,
                const AllowedPaths* files);

  void start();
  /// Topics of targets follow the grasps there are. Network: not on the simulation thread.
  void update(const std::vector<std::string>& grasp_names);
  void target(const std::string& grasp, const geometry_msgs::PoseStamped& pose);

 private:
  void grasp_command(const msg::GraspCommand& message);
  void obstacle(const msg::Obstacle& message);
  void refuse(const std::string& what, const std::string& why);
  Done reporter(const std::string& what);

  ros::NodeHandle nh_;
  Simulation* simulation_;
  Frames* frames_;
  Warnings* warnings_;
  const AllowedPaths* files_;
  std::vector<ros::Subscriber> fixed_;
  std::map<std::string, ros::Subscriber> targets_;
};

/// All services of the node.
class Services {
 public:
  Services(const ros::NodeHandle& private_nh, const Parameters& parameters, Simulation* simulation, Frames* frames,
           SceneChanges* changes, Rollouts* rollouts, const AllowedPaths* files);

  void start();
  /// Full names.
  std::vector<std::string> names() const;

 private:
  void advertise_grasps();
  void advertise_time();
  void advertise_scene();
  void advertise_changes();
  void step(const msg::StepRequest& request, msg::StepResponse* response);
  void get_state(const msg::GetStateRequest& request, msg::GetStateResponse* response);
  void get_distance(const msg::GetDistanceRequest& request, msg::GetDistanceResponse* response);
  void set_state(const msg::SetStateRequest& request, msg::SetStateResponse* response);
  Reply add_obstacle(const msg::AddObstacleRequest& request);

  ros::NodeHandle nh_;
  std::string frame_id_;
  Simulation* simulation_;
  Frames* frames_;
  SceneChanges* changes_;
  Rollouts* rollouts_;
  const AllowedPaths* files_;
  SavedStates saved_states_;
  std::vector<ros::ServiceServer> servers_;
};

}  // namespace deformable_sim
