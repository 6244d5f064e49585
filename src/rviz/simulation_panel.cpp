#include "deformable_sim/rviz/simulation_panel.h"

#include <QVBoxLayout>

#include <ros/names.h>
#include <rviz/config.h>
#include <pluginlib/class_list_macros.hpp>

#include "deformable_sim/rviz/graph_names.h"

namespace deformable_sim {

SimulationPanel::SimulationPanel(QWidget* parent) : rviz::Panel(parent), view_(new SimulationView(&link_)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(view_);
  view_->set_node(QString::fromStdString(ros::names::resolve("deformable_sim")));
  connect(view_, &SimulationView::node_changed, this, &rviz::Panel::configChanged);
}

// The view speaks to the link, so it goes first.
SimulationPanel::~SimulationPanel() {
  delete view_;
}

void SimulationPanel::load(const rviz::Config& config) {
  rviz::Panel::load(config);
  QString node;
  if (config.mapGetString("Simulation Node", &node) && is_node_name(node)) {
    view_->set_node(QString::fromStdString(ros::names::resolve(node.toStdString())));
  }
}

void SimulationPanel::save(rviz::Config config) const {
  rviz::Panel::save(config);
  config.mapSetValue("Simulation Node", view_->node());
}

}  // namespace deformable_sim

PLUGINLIB_EXPORT_CLASS(deformable_sim::SimulationPanel, rviz::Panel)
