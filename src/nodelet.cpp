// The simulation as a nodelet: deformable_sim/Simulation.
#include <memory>

#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/node.h"

namespace deformable_sim {

/// Loaded as a whole or, where a parameter or the scene is refused, not at all. Subscribers in the same manager get
/// clouds, markers, images and states without a copy.
class SimulationNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      server_ = std::make_unique<SimulationServer>(getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<SimulationServer> server_;
};

}  // namespace deformable_sim

PLUGINLIB_EXPORT_CLASS(deformable_sim::SimulationNodelet, nodelet::Nodelet)
