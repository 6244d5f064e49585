// Contacts inside an implicit step: stiff penalties and regularised Coulomb friction.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/stick.h"
#include "deformable_sim/core/linear/block_matrix.h"
#include "deformable_sim/core/linear/node_couplings.h"

namespace deformable_sim {

/// On the contact point p with gap g and tangential displacement u from where it stuck, turned with the surface:
///
///   normal force    k max(0, -g),   k = 100 m / dt^2: the gap is a hundredth of what free motion would have made it
///   friction       -mu lambda u / max(|u|, kStickGive)
///
/// u = ContactConstraint::stuck + the motion relative to the surface since the start of the step, or of the part of one
/// that a stage takes; report() leaves in `stuck` what the friction can hold of it (stick_remainder), for the next part
/// and the next step. So what sticks does not creep: it comes back to the place where its friction spring carries it.
///
/// lambda is the normal force of an earlier Newton iterate, so that the forces of one iterate have a convex potential.
class PenaltyContacts {
 public:
  /// A step, or a part of one that ends at a stage, s.
  struct Span {
    double duration;   // of the part
    double remaining;  // from its end to the end of the step, where the planes of the constraints are
    double unit;  // dt of the stiffness k: the same in all parts of a step, so that what rests does so at one depth
  };
  /// Stiffnesses, and lambda of the contacts closed at x. inverse_mass is 0 for prescribed nodes; `start` are the
  /// positions before, x the same with prescribed nodes at their targets.
  void begin(const Span& span, const Nodes& start, const Nodes& x, const Eigen::VectorXd& inverse_mass,
             const ContactConstraints& constraints);
  /// f += normal forces found by begin(), and the friction there is where nothing has moved yet.
  void add_resting_force(Nodes* f) const;
  /// lambda from the positions x.
  void update_normal_forces(const Nodes& x);
  /// Is a point at x further behind its plane than `depth` (m)?
  bool any_deeper(double depth, const Nodes& x) const;
  /// Last resort after a solve that did not converge: moves points that are deeper than `depth` (m) back to it, each in
  /// turn and by the inverse masses of its nodes, so that nothing gets through a thin collider.
  void push_out(double depth, const Eigen::VectorXd& inverse_mass, Nodes* x) const;
  /// f += contact forces at x.
  void add_force(const Nodes& x, Nodes* f) const;
  /// A += -df/dx at x, symmetric and positive semi-definite; of contacts between bodies, whose nodes the pattern need
  /// not join, the diagonal blocks, and all of it to `couplings`. Nodes of inverse_mass 0 are held.
  void add_jacobian(const Nodes& x, const Eigen::VectorXd& inverse_mass, BlockMatrix* a, NodeCouplings* couplings);
  /// visit(constraint, h) for each closed contact: -df/dp of its point p at x, as in add_jacobian().
  template <class Visit>
  void for_each_jacobian(const Nodes& x, const Visit& visit) {
    for (Contact& c : contacts_) {
      const Vec3 p = point(c, x);
      if (gap(c, p) < 0.0 && c.stiffness > 0.0) visit(c.plane, jacobian(&c, p));
    }
  }
  /// Writes ContactConstraint::force and stuck.
  void report(const Nodes& x, ContactConstraints* constraints) const;
  bool empty() const { return contacts_.empty(); }

 private:
  struct Contact {
    ContactConstraint plane;
    double stiffness = 0.0;         // k, N/m; 0 when the point cannot move
    double normal_force = 0.0;      // lambda, N
    Vec3 reference = Vec3::Zero();  // where the point would be had it moved with the surface, and without friction
    Vec3 sliding = Vec3::Zero();    // u at the last Jacobian
    int turns = 0;                  // how often sliding has turned round between two Jacobians of this step
    int cautious = 0;               // Jacobians that still have to bound the friction from above
  };
  static Vec3 point(const Contact& c, const Nodes& x) { return contact_position(c.plane, x); }
  static double gap(const Contact& c, const Vec3& p) { return c.plane.normal.dot(p) - c.plane.offset; }
  static Vec3 sliding(const Contact& c, const Vec3& p);
  Vec3 force(const Contact& c, const Vec3& p) const;
  Mat3 jacobian(Contact* c, const Vec3& p) const;

  double unit_ = 0.0;  // s
  std::vector<Contact> contacts_;
};

}  // namespace deformable_sim
