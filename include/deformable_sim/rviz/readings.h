// What a running simulation says, shown: plots, step cost, grasps, warnings.
#pragma once

#include <QLabel>
#include <QWidget>

#include "deformable_sim/GraspStateArray.h"
#include "deformable_sim/SimStatus.h"
#include "deformable_sim/rviz/bar_list.h"
#include "deformable_sim/rviz/plot.h"

namespace deformable_sim {

class Readings : public QWidget {
  Q_OBJECT

 public:
  explicit Readings(QWidget* parent = nullptr);

  /// Takes a message; what is drawn changes with refresh().
  void add(const SimStatusConstPtr& status);
  void add(const GraspStateArrayConstPtr& grasps);
  void refresh();
  void clear();

 private:
  void refresh_status(const SimStatus& status);
  void refresh_grasps(const GraspStateArray& grasps);

  QLabel* summary_;
  Plot* real_time_factor_;
  Plot* strain_;
  Plot* energy_;
  Plot* potential_;
  QLabel* span_;
  QLabel* cost_title_;
  BarList* cost_;
  QLabel* grasps_title_;
  BarList* grasps_;
  QLabel* warnings_;

  SimStatusConstPtr status_;
  GraspStateArrayConstPtr last_grasps_;
  double largest_force_ = 0;  // N, of grasps without a limit
  bool changed_ = false;
};

}  // namespace deformable_sim
