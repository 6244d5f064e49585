#include "deformable_sim/rviz/simulation_link.h"

namespace deformable_sim {

SimulationLink::SimulationLink(QObject* parent) : QObject(parent) {
  // Signals from other threads carry these.
  qRegisterMetaType<deformable_sim::SimStatusConstPtr>("deformable_sim::SimStatusConstPtr");
  qRegisterMetaType<deformable_sim::GraspStateArrayConstPtr>("deformable_sim::GraspStateArrayConstPtr");
}

}  // namespace deformable_sim
