// The whole of a simulation under one name: what the node and the nodelet run.
#pragma once

#include <memory>

#include <ros/node_handle.h>

namespace deformable_sim {

/// Parameters are read and the scene is loaded on construction, which throws InputError; topics and services are there
/// from then on until it is destroyed. Callbacks have a queue and threads of their own: they may wait. Of what the
/// libraries put on the global queue (dragging of interactive markers) whoever owns the process takes care.
class SimulationServer {
 public:
  explicit SimulationServer(const ros::NodeHandle& private_nh);
  ~SimulationServer();
  SimulationServer(const SimulationServer&) = delete;
  SimulationServer& operator=(const SimulationServer&) = delete;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

/// Runs one until ROS is shut down. Returns the exit code: 0, 2 for a scene or parameter that was refused, else 1.
int run_node(int argc, char** argv);

}  // namespace deformable_sim
