// How far a trajectory is from another one of the same bodies.
#pragma once

#include <memory>

#include "deformable_sim/core/model.h"
#include "work_precision.h"

namespace deformable_sim::work_precision {

class Yardstick {
 public:
  /// Bodies, and the state they start from: its extent is their size, its stored energy the zero.
  Yardstick(std::shared_ptr<const Model> model, const State& start);

  /// sqrt(mean |(a - b) / L|^2) over the points of all bodies, L the longest side of their body's bounds at the start.
  double distance(const Nodes& a, const Nodes& b) const;
  /// Of the quarters both have; NaN when they have none.
  double position(const Trajectory& run, const Trajectory& reference) const;
  Errors errors(const Trajectory& run, const Trajectory& reference) const;
  /// Length, area or volume of a body (m, m^2, m^3).
  static double measure(const Body& body, const Nodes& x);
  const Model& model() const { return *model_; }

 private:
  double energy_error(const Trajectory& run, const Trajectory& reference) const;
  double measure_error(const Trajectory& run, const Trajectory& reference) const;
  double strain_error(const Trajectory& run, const Trajectory& reference) const;
  double grasp_error(const Trajectory& run, const Trajectory& reference) const;

  std::shared_ptr<const Model> model_;
  std::vector<double> size_;   // m, of each body
  double stored_start_ = 0.0;  // J
};

}  // namespace deformable_sim::work_precision
