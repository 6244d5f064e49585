// The panel of rviz: plays, steps and watches a simulation.
#pragma once

#include <rviz/panel.h>

#include "deformable_sim/rviz/ros_link.h"
#include "deformable_sim/rviz/simulation_view.h"

namespace deformable_sim {

class SimulationPanel : public rviz::Panel {
  Q_OBJECT

 public:
  explicit SimulationPanel(QWidget* parent = nullptr);
  ~SimulationPanel() override;

  // Keeps the node's name; one that was remapped for rviz (/deformable_sim:=/left) is followed to its new name.
  void load(const rviz::Config& config) override;
  void save(rviz::Config config) const override;

 private:
  RosLink link_;
  SimulationView* view_;
};

}  // namespace deformable_sim
