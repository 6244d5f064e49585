// Stages of scenes that are made of sheets on grids.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/integrator/implicit_stage.h"
#include "deformable_sim/core/integrator/sheet_solve.h"

namespace deformable_sim {

/// Solves the sheets one by one (SheetSolve). Where there is more than they know, that is nodes of no sheet, a
/// consistent mass matrix, or terms other than weight, mass damping, soft grasps and strain limits, all is left to an
/// ImplicitStage with conjugate gradients.
class SheetStage : public StageSolver {
 public:
  explicit SheetStage(const SolverSettings& settings) : settings_(settings), generic_(settings) {}

  void reset() override;
  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d) override;
  void find_force(const State& s, const Dynamics& d, Nodes* f) override;
  State& end() override { return fits_ ? end_ : generic_.end(); }
  const Nodes& force() const override { return fits_ ? force_ : generic_.force(); }
  const Nodes& outer_force() const override { return fits_ ? outer_force_ : generic_.outer_force(); }
  void report_contacts(ContactConstraints* contacts) const override;

  /// Whether the sheets are all there is, so that stages need no matrix. Kinematics and contacts do not matter.
  static bool is_enough_for(const Dynamics& d);

 private:
  void prepare(const Dynamics& d);

  SolverSettings settings_;
  ImplicitStage generic_;
  bool prepared_ = false, fits_ = false;
  SheetSurroundings around_;
  std::vector<std::unique_ptr<SheetSolve>> sheets_;
  State end_;
  Nodes force_, outer_force_;
};

}  // namespace deformable_sim
