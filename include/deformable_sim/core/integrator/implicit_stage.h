// What all implicit schemes share: one nonlinear solve for the positions at a stage of the step.
#pragma once

#include <vector>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/penalty_contacts.h"
#include "deformable_sim/core/integrator/stage_matrix.h"

namespace deformable_sim {

/// The unknown x of a stage obeys
///
///   v = (x - x_base) / tau,   a = (v - v_base) / tau,   M a = f(x, v) + more_force + contacts,
///
/// which is implicit Euler with other bases: every linear multistep and diagonally implicit Runge-Kutta scheme is made
/// of such stages. Nodes that a contact constraint names follow implicit Euler's formula from the start of the stage,
/// v = (x - x_start) / duration, a = (v - v_start) / duration, whatever the scheme: a formula that remembers, or that
/// extrapolates, throws a stopped node back.
struct StageEquation {
  double tau = 0.0;                    // s
  const Nodes* x_base = nullptr;       // 3 x n, m
  const Nodes* v_base = nullptr;       // 3 x n, m/s
  const Nodes* more_force = nullptr;   // 3 x n, N; null = none
  const Nodes* start_force = nullptr;  // 3 x n, N: the terms' force at the start, if known
  double duration = 0.0;               // s from the start to the stage
  double fraction = 1.0;               // of the way of prescribed nodes from the start to their targets
  double remaining = 0.0;              // s from the stage to the end of the step
  double contact_unit = 0.0;           // s, dt of the contacts' stiffness

  PenaltyContacts::Span contact_span() const { return {duration, remaining, contact_unit}; }
};

/// Newton's method for one stage; work space and preconditioner are kept from step to step.
///
/// The residual M a - f - more_force - contacts is made small from the start positions or from the explicit guess
/// x_base + tau v_base + tau^2 M^-1 (f(start) + more_force), whichever has the smaller residual: a body at rest starts
/// from where it is, so that an unconverged step cannot drift away from an equilibrium. The matrix is
/// M / tau^2 - df/dx - df/dv / tau, projected, so that every Newton direction is a descent direction.
///
/// Linearised, f is replaced by its expansion about the start, f0 + K (x - x0) + C (v - v0), K and C exact: one linear
/// solve, or a few with the same matrix where contacts close. If the matrix is then not definite (springs compressed
/// beyond m / tau^2), the projected K and C take their place.
class ImplicitStage {
 public:
  enum class Forces { kNonlinear, kLinearised };
  explicit ImplicitStage(const SolverSettings& settings, Forces forces = Forces::kNonlinear)
      : settings_(settings), linearised_(forces == Forces::kLinearised), matrix_(settings) {}

  void reset() { matrix_.reset(); }
  StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d);

  /// Of the last solve: x, v and time at the stage; may be swapped away.
  State& end() { return trial_; }
  /// The terms' force there, N (not known after a linearised solve).
  const Nodes& force() const { return force_; }
  /// M a - f - more_force there, N: what holders and contacts do to the nodes.
  const Nodes& outer_force() const { return base_; }
  /// Writes the force of each contact.
  void report_contacts(ContactConstraints* contacts) const { contacts_.report(trial_.x, contacts); }

 private:
  void begin(const StageEquation& equation, const State& start, const Dynamics& d);
  void find_near_nodes();
  double start_iteration();
  void guess();
  void find_velocities();
  void evaluate();
  void add_inertia();
  void linearise(Jacobian kind);
  void add_contacts();
  bool is_rough(const StepReport& report) const;
  double unbalanced(const Nodes& residual) const;
  void assemble(StepReport* report);
  bool solve_linear(StepReport* report);
  void search_along_step();
  void try_fraction(double fraction);

  SolverSettings settings_;
  bool linearised_;
  StageMatrix matrix_;
  PenaltyContacts contacts_;

  // The present stage.
  StageEquation equation_;
  double tau_ = 0.0;
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
};

}  // namespace deformable_sim
