// What explicit schemes share: accelerations, prescribed nodes, reactions and contacts.
#pragma once

#include <vector>

#include "deformable_sim/core/integrator/integrator.h"

namespace deformable_sim {

/// Work space of one explicit step.
///
/// Prescribed nodes move linearly to their targets; the others obey M a = f. Contacts are resolved after the step, each
/// exactly and in turn (Gauss-Seidel): inelastic normal impulse, Coulomb friction clamped to mu times it.
class ExplicitStep {
 public:
  /// Remembers the state at the start of the step.
  void begin(double dt, Dynamics* d, const State& s);
  /// Accelerations (m/s^2) at `s`; zero for prescribed nodes.
  void acceleration(const State& s, Nodes* a);
  /// Puts prescribed nodes where they are after `fraction` of the step, and their velocity.
  void prescribe(double fraction, State* s) const;
  /// Contacts, reactions and the report. `drift` is the share of a velocity change in this step that also moves the
  /// nodes within it: 1 when x follows the new velocity, 0 when it follows the old one.
  StepReport finish(double drift, State* s);

 private:
  struct Contact {
    double mass;    // effective mass of the point, kg; 0 when it cannot move
    double normal;  // accumulated impulse, N s
    Vec3 friction;  // accumulated impulse, N s
  };
  void resolve_contacts(double drift, State* s);
  void resolve(const ContactConstraint& c, double drift, Contact* contact, State* s) const;
  void add_to_velocities(const ContactConstraint& c, const Vec3& impulse, State* s) const;
  void add_to_positions(const ContactConstraint& c, const Vec3& moment, State* s) const;

  double dt_ = 0.0;
  Dynamics* dynamics_ = nullptr;
  Nodes x0_, v0_;                 // of prescribed nodes, at the start
  Nodes force_, start_force_;     // of all nodes; of prescribed nodes at the start of the step
  Eigen::VectorXd inverse_mass_;  // 0 for prescribed nodes
  std::vector<Contact> contacts_;
  bool first_force_ = true;
};

}  // namespace deformable_sim
