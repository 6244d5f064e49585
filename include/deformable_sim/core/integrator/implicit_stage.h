// What all implicit schemes share: one nonlinear solve for the positions at a stage of the step.
#pragma once

#include <vector>

#include "deformable_sim/core/integrator/stage_matrix.h"
#include "deformable_sim/core/integrator/stage_solver.h"

namespace deformable_sim {

/// Whether a step is so short that round-off of the positions, over tau^2, is more than an acceleration that matters.
bool is_unresolved(double tau, const State& start, const Dynamics& d);

/// Newton's method for one stage; work space and preconditioner are kept from step to step.
///
/// The residual M a - f - more_force - contacts is made small from the start positions or from the explicit guess
/// x_base + tau v_base + tau^2 M^-1 (f(start) + more_force), whichever has the smaller residual: a body at rest starts
/// from where it is, so that an unconverged step cannot drift away from an equilibrium. The matrix is
/// M / tau^2 - df/dx - df/dv / tau, projected, so that every Newton direction is a descent direction.
///
/// Full steps (Jacobian::kLagged with a solver that keeps its factors, no contacts in reach): in stiff ropes a motion
/// far below what matters makes a huge unbalanced force, so that neither the residual nor the work along a step say how
/// far the solution is. Newton then starts from x_base + tau v_base + tau^2 a of the last step, takes whole steps, and
/// what is left is measured as A^-1 r / tau^2 with the last factors: the acceleration that one more step would add.
/// That is the report's residual, and what the tolerance is for.
///
/// With multigrid Newton starts from x_start + duration v_start: few iterations of it leave spring forces that are
/// large and short-lived, and a guess made of them costs more than it saves. A body at rest still starts from where it
/// is.
///
/// Steps that are unresolved, of less than about 0.1 us, are solved for velocities instead.
///
/// Linearised, f is replaced by its expansion about the start, f0 + K (x - x0) + C (v - v0), K and C exact: one linear
/// solve, or a few with the same matrix where contacts close. If the matrix is then not definite (springs compressed
/// beyond m / tau^2), the projected K and C take their place.
class ImplicitStage : public StageSolver {
 public:
  enum class Forces { kNonlinear, kLinearised };
  explicit ImplicitStage(const SolverSettings& settings, Forces forces = Forces::kNonlinear,
                         StageMatrix::Links links = StageMatrix::Links::kInBlocks)
      : settings_(settings),
        linearised_(forces == Forces::kLinearised),
        coasts_(links == StageMatrix::Links::kApart),
        matrix_(settings, links) {}

  void reset() override { matrix_.reset(); }
  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d) override;
  void find_force(const State& s, const Dynamics& d, Nodes* f) override;

  State& end() override { return trial_; }
  /// Not known after a linearised solve.
  const Nodes& force() const override { return force_; }
  const Nodes& outer_force() const override { return base_; }
  void report_contacts(ContactConstraints* contacts) const override { contacts_.report(trial_.x, contacts); }

 private:
  double start_full_steps();
  void take_full_step();
  double leave_full_steps();
  double left_over();
  void begin(const StageEquation& equation, const State& start, const Dynamics& d);
  void find_near_nodes();
  double start_iteration();
  double coast();
  StepReport solve_for_velocities();
  void guess();
  void find_velocities();
  void evaluate();
  void add_inertia();
  void linearise(Jacobian kind);
  void add_contacts();
  bool is_rough(const StepReport& report) const;
  double unbalanced(const Nodes& residual) const;
  void assemble();
  double lap();
  bool solve_linear(StepReport* report);
  void search_along_step();
  void try_fraction(double fraction);

  SolverSettings settings_;
  bool linearised_, coasts_;
  StageMatrix matrix_;
  PenaltyContacts contacts_;

  // The present stage.
  StageEquation equation_;
  double tau_ = 0.0;
  double lap_ = 0.0;  // s, thread CPU time
  int force_evaluations_ = 0;
  const Dynamics* dynamics_ = nullptr;
  const State* start_ = nullptr;
  State trial_;
  Nodes step_, before_, other_, force_;
  Nodes base_, residual_;         // base_ = M a - f; residual_ = contacts - base_, the direction to go
  Nodes work_;                    // only with a mass matrix or when linearised
  Eigen::VectorXd inverse_mass_;  // 0 at held nodes
  double free_ = 1.0;             // number of free nodes
  std::vector<int> near_;         // free nodes that follow implicit Euler's formula though the scheme is another
  std::vector<char> is_near_;     // by node

  // Linearised: base_ = linear_ (x - x_base - tau v_base) - linear_force_.
  Jacobian linear_kind_ = Jacobian::kExact;
  BlockMatrix linear_;
  Nodes linear_force_;
  bool assembled_ = false;

  // With a lagged Jacobian, an exact solver and no contacts: whole Newton steps, judged by what another would do.
  bool full_steps_ = false;
};

}  // namespace deformable_sim
