// The equation that all implicit schemes are made of, and the interface of what solves it.
#pragma once

#include <memory>
#include <string>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/penalty_contacts.h"

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
  bool force_wanted = true;            // force() will be asked for

  PenaltyContacts::Span contact_span() const { return {duration, remaining, contact_unit}; }
};

/// Solves stages; keeps work space and what it knows of the matrix from step to step.
class StageSolver {
 public:
  virtual ~StageSolver() = default;
  /// Terms or held nodes have changed.
  virtual void reset() = 0;
  virtual StepReport solve(const StageEquation& equation, const State& start, const Dynamics& d) = 0;

  /// Whether solve() makes use of the acceleration (v - v_before) / dt_before of State, where it is known.
  virtual bool extrapolates() const { return false; }

  /// f := the terms' force at `s`, N.
  virtual void find_force(const State& s, const Dynamics& d, Nodes* f) = 0;
  /// The same of held nodes; all others may be left as they are.
  virtual void find_held_force(const State& s, const Dynamics& d, Nodes* f) { find_force(s, d, f); }
  /// Of the last solve: x, v and time at the stage; may be swapped away.
  virtual State& end() = 0;
  /// The terms' force there, N; of no meaning where it was not wanted.
  virtual const Nodes& force() const = 0;
  /// M a - f - more_force there, N: what holders and contacts do to the nodes. May be known at held nodes only.
  virtual const Nodes& outer_force() const = 0;
  /// Writes the force of each contact.
  virtual void report_contacts(ContactConstraints* contacts) const = 0;
};

/// Schemes that solve stages with make_stage_solver() and need a matrix for nothing else.
bool is_in_stages(const std::string& integrator);

/// What settings.linear asks for: SheetStage for multigrid, ImplicitStage for all else.
std::unique_ptr<StageSolver> make_stage_solver(const SolverSettings& settings);
/// Of schemes that make their stages with it.
Needs stage_needs(const SolverSettings& settings);

}  // namespace deformable_sim
