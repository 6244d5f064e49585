// What explicit schemes share: accelerations, prescribed nodes, reactions and contacts.
#pragma once

#include <memory>

#include "deformable_sim/core/integrator/impulse_contacts.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/integrator/mass_factor.h"

namespace deformable_sim {

/// Work space of one explicit step.
///
/// Prescribed nodes move linearly to their targets; the others obey M a = f. Contacts are resolved after the step.
class ExplicitStep {
 public:
  /// Remembers the state at the start of the step.
  void begin(double dt, Dynamics* d, const State& s);
  /// Accelerations (m/s^2) at `s`; zero for prescribed nodes. `weight` is the share of these forces in the step's
  /// momentum, the shares of a step add up to 1: what holders feel is the mean over the step.
  void acceleration(const State& s, double weight, Nodes* a);
  /// Puts prescribed nodes where they are after `fraction` of the step, and their velocity.
  void prescribe(double fraction, State* s) const;
  /// Contacts, reactions and the report. `drift` is the share of a velocity change in this step that also moves the
  /// nodes within it: 1 when x follows the new velocity, 0 when it follows the old one.
  StepReport finish(double drift, State* s);

 private:
  void find_reactions(const State& s);

  double dt_ = 0.0;
  int force_evaluations_ = 0;  // in this step
  Dynamics* dynamics_ = nullptr;
  Nodes x0_, v0_;                 // of prescribed nodes, at the start
  Nodes force_, mean_force_;      // of all nodes; of prescribed nodes, mean over the step
  Eigen::VectorXd inverse_mass_;  // 0 for prescribed nodes
  ImpulseContacts contacts_;
  std::unique_ptr<MassFactor> mass_factor_;  // only with a mass matrix
  Nodes v_start_, prescribed_inertia_;       // of all nodes; only with a mass matrix
};

}  // namespace deformable_sim
