// Stages of scenes that are made of ropes.
#pragma once

#include <vector>

#include "deformable_sim/core/integrator/implicit_stage.h"
#include "deformable_sim/core/integrator/rope_solve.h"

namespace deformable_sim {

/// Solves the ropes one by one (RopeSolve): open chains of springs and line bending, with weight, mass damping, held
/// nodes and soft grasps. Where there is more than that (rods with twist, closed loops, strain limits, air drag, other
/// bodies), while contacts are in reach, and where whole Newton steps lead nowhere, all is left to an ImplicitStage.
class RopeStage : public StageSolver {
 public:
  explicit RopeStage(const SolverSettings& settings);

  void reset() override;
  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d) override;
  bool extrapolates() const override { return true; }
  void find_force(const State& s, const Dynamics& d, Nodes* f) override;
  void find_held_force(const State& s, const Dynamics& d, Nodes* f) override;
  State& end() override { return solved_ ? end_ : generic_.end(); }
  /// Of held nodes only; zero elsewhere.
  const Nodes& force() const override { return solved_ ? force_ : generic_.force(); }
  const Nodes& outer_force() const override { return solved_ ? outer_force_ : generic_.outer_force(); }
  void report_contacts(ContactConstraints* contacts) const override;

 private:
  void prepare(const Dynamics& d);
  StepReport solve_otherwise(const StageEquation& equation, const State& start, const Dynamics& d);

  SolverSettings settings_;
  ImplicitStage generic_;
  bool prepared_ = false, fits_ = false;
  bool solved_ = false;  // the last stage, by the ropes themselves
  RopeSurroundings around_;
  /// One rope's part of a stage.
  struct Part {
    bool solved;
    StepReport report;
  };
  std::vector<RopeSolve> ropes_;
  std::vector<Part> parts_;
  const Workers* workers_ = nullptr;  // null: one rope after the other
  State end_;
  Nodes force_, outer_force_;
};

}  // namespace deformable_sim
