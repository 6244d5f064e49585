// Strain limiting: what is longer than it may be after a step is made shorter.
#pragma once

#include <vector>

#include "deformable_sim/core/energy/limit_springs.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/model.h"
#include "deformable_sim/core/strain_projection.h"

namespace deformable_sim {

/// Limits for links: longest = (1 + limit) rest length. limit: > 0, relative. Throws InputError on another one.
std::vector<StrainLimit> strain_limits(const std::vector<SpringLink>& links, double limit, int first_node);

/// Keeps all limits |x_b - x_a| <= longest of a model at the end of every step [Provot 1995], in two stages.
///
/// Schemes that take a Jacobian feel the tension of the last step while they solve (LimitSprings), so that friction,
/// soft grasps and contacts meet a body that hangs on its limits. What is still too long after the step is projected
/// away, mass-weighted and exactly (StrainProjection). Explicit schemes are projected only.
///
/// Tensions are kept in State, so that a saved state continues to the bit.
/// Not good at: rotation, which loses as much as in an implicit Euler step; limits that held nodes contradict, whose
/// excess is spread.
class StrainLimiter {
 public:
  explicit StrainLimiter(const Model& model);

  /// Tension within the step, for schemes that take a Jacobian: add to their energies.
  LimitSprings* springs() { return &springs_; }
  /// Before a step of dt (s) with these held nodes.
  void begin(double dt, const Kinematics& kinematics, State* s);
  /// After it: moves `s`, its velocities with it, and adds to the reactions and contact forces of `d`.
  StrainLimitReport project(double dt, Dynamics* d, State* s);
  /// Positions that were not stepped to, into the limits, without a velocity: what a step takes back it gives in m/s.
  /// Returns how far the furthest node went, m.
  double take_in(const Kinematics& kinematics, Nodes* x);
  int count() const { return springs_.element_count(); }

 private:
  void find_inverse_mass(const Kinematics& kinematics);
  double worst(const Nodes& x) const;
  void add_forces(double dt, Dynamics* d, const State& s);

  const Eigen::VectorXd& mass_;
  std::vector<double> body_stiffness_;  // N/m, parallel to the springs
  LimitSprings springs_;
  Eigen::VectorXd inverse_mass_;                   // 0 at held nodes
  std::vector<double> impulse_, contact_impulse_;  // kg m, of the last projection
  Nodes before_, held_force_;
  StrainProjection projection_;
};

}  // namespace deformable_sim
