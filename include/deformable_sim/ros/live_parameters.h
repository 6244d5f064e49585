// dynamic_reconfigure: what may change while the simulation runs.
#pragma once

#include <memory>
#include <string>

#include <ros/node_handle.h>

#include "deformable_sim/ros/scene_changes.h"
#include "deformable_sim/ros/warnings.h"

namespace deformable_sim {

/// Values are those of the scene, at the start and whenever it changes: what a launch file or an earlier run has left
/// on the parameter server counts for nothing. What is set goes through the checks of the scene file; refused, it is
/// set back, logged and listed in ~status.
class LiveParameters {
 public:
  LiveParameters(const ros::NodeHandle& private_nh, SceneChanges* changes, Warnings* warnings);
  ~LiveParameters();

  /// Opens the topics and the service, with the values of `scene`.
  void start(const SceneSpec& scene);
  /// Full name.
  std::string service() const { return nh_.resolveName("set_parameters"); }

 private:
  class Server;

  ros::NodeHandle nh_;
  SceneChanges* changes_;
  Warnings* warnings_;
  std::unique_ptr<Server> server_;
};

}  // namespace deformable_sim
