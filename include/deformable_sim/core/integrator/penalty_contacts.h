// Contacts inside an implicit step: stiff penalties with an active set, and regularised Coulomb friction.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/linear/block_matrix.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

/// Normal force lambda = max(0, -k gap), friction mu lambda, both with a stiffness of a thousand times the inertia
/// m / dt^2 of the contact point: the gap error is a thousandth of what the point would have moved freely.
///
/// A Newton step works with fixed modes (open, sticking, sliding): within it the laws are linear or constant, so that a
/// contact closing or breaking loose does not stop a line search; update() then corrects the modes.
class PenaltyContacts {
 public:
  /// Start of a step: stiffnesses, and modes from where the free motion would lead.
  /// inverse_mass is 0 for prescribed nodes; `start` is the state at the beginning of the step.
  void begin(double dt, const State& start, const Nodes& guess, const Eigen::VectorXd& inverse_mass,
             const ContactConstraints& constraints);
  /// Modes and normal forces from the positions x. `normal_forces` false keeps the latter, so that friction settles.
  enum class Update { kAll, kModesOnly };
  void update(const Nodes& x, Update what);
  /// f += contact forces at x, with the present modes.
  void add_force(const Nodes& x, Nodes* f) const;
  /// A += -df/dx (symmetric, positive semi-definite).
  void add_jacobian(BlockMatrix* a) const;
  /// Writes ContactConstraint::force.
  void report(const Nodes& x, ContactConstraints* constraints) const;
  bool empty() const { return contacts_.empty(); }

 private:
  enum class Mode { kOpen, kStick, kSlide };
  struct Contact {
    ContactConstraint plane;
    double stiffness = 0.0;         // normal, N/m
    double stick_stiffness = 0.0;   // tangential, N/m
    double inertia = 0.0;           // effective mass of the point, kg
    double normal_force = 0.0;      // lambda used by friction, N
    Vec3 reference = Vec3::Zero();  // where the point would be had it moved with the surface
    Vec3 direction = Vec3::Zero();  // of sliding, unit
    double slid = 0.0;              // distance slid, m
    Mode mode = Mode::kOpen;
  };
  Vec3 point(const Contact& c, const Nodes& x) const;
  Vec3 force(const Contact& c, const Vec3& p) const;
  Mat3 jacobian(const Contact& c) const;
  void set_friction_mode(const Vec3& sliding, Contact* c) const;

  double dt_ = 0.0;
  std::vector<Contact> contacts_;
};

}  // namespace deformable_sim
