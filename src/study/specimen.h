// What is put on the virtual test bench: nodes, masses and energies, held here and loaded there.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "statics.h"

namespace deformable_sim::study {

class Specimen {
 public:
  /// Lies at `rest` without motion.
  Specimen(const Nodes& rest, Eigen::VectorXd mass);

  void add(std::unique_ptr<Energy> energy);
  /// Holds one coordinate, or a whole node, where it is when settle() is called.
  void hold(int node, int axis);
  void hold(int node);
  /// Adds a constant force (N).
  void load(int node, const Vec3& force);
  /// Gravity (m/s^2) on the masses; angle columns, beyond `points`, have no weight.
  void weigh(const Vec3& gravity, int points);

  Equilibrium settle(const StaticsSettings& settings = {});
  /// Did the last settle() find an equilibrium? Nothing can be measured where it did not.
  bool settled() const { return settled_; }

  /// What holds a node: minus the energies' force on it, N.
  Nodes reactions() const;

  int node_count() const { return static_cast<int>(rest.cols()); }
  Nodes rest;
  State state;
  Eigen::VectorXd mass;

 private:
  std::vector<std::unique_ptr<Energy>> energies_;
  std::vector<char> held_;
  Nodes loads_;
  bool settled_ = false;
};

}  // namespace deformable_sim::study
