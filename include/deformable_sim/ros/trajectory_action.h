// The ~follow_trajectory action.
#pragma once

#include <memory>

#include <ros/node_handle.h>

#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/simulation.h"

namespace deformable_sim {

/// One goal at a time; a new one takes the place of the old one. Feedback 20 times a second (wall).
class TrajectoryAction {
 public:
  TrajectoryAction(const ros::NodeHandle& private_nh, Simulation* simulation, Frames* frames, std::string frame_id);
  ~TrajectoryAction();

  void start();
  /// Before the simulation goes.
  void stop();

 private:
  class Server;

  ros::NodeHandle nh_;
  Simulation* simulation_;
  Frames* frames_;
  std::string frame_id_;
  std::unique_ptr<Server> server_;
};

}  // namespace deformable_sim
