// Stages of scenes that are made of sheets on grids.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/integrator/implicit_stage.h"
#include "deformable_sim/core/integrator/sheet_solve.h"

namespace deformable_sim {

/// Whether SheetSolve knows everything that acts: no nodes beside those of sheets on grids, no consistent mass matrix,
/// and no terms other than the sheets' own, weight, mass damping, soft grasps and strain limits.
bool sheets_fit(const Dynamics& d);

/// Solves the sheets one by one (SheetSolve) where sheets_fit(); else all is left to an ImplicitStage with a
/// MultigridSolver, as are steps too short for positions.
class SheetStage : public StageSolver {
 public:
  explicit SheetStage(const SolverSettings& settings)
      : settings_(settings), generic_(settings, ImplicitStage::Forces::kNonlinear, StageMatrix::Links::kApart) {}

  void reset() override;
  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d) override;
  void find_force(const State& s, const Dynamics& d, Nodes* f) override;
  State& end() override { return in_rows_ ? end_ : generic_.end(); }
  const Nodes& force() const override { return in_rows_ ? force_ : generic_.force(); }
  const Nodes& outer_force() const override { return in_rows_ ? outer_force_ : generic_.outer_force(); }
  void report_contacts(ContactConstraints* contacts) const override;

 private:
  void prepare(const Dynamics& d);

  SolverSettings settings_;
  ImplicitStage generic_;
  bool prepared_ = false, fits_ = false;
  bool in_rows_ = false;  // the last solve
  SheetSurroundings around_;
  std::vector<std::unique_ptr<SheetSolve>> sheets_;
  std::vector<StepReport> reports_;   // of each sheet
  const Workers* workers_ = nullptr;  // of whole sheets; null: one after the other
  State end_;
  Nodes force_, outer_force_;
};

}  // namespace deformable_sim
