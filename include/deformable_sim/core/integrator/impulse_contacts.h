// Contacts of explicit schemes, resolved one after the other by impulses.
#pragma once

#include <vector>

#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

/// Each contact exactly and in turn (Gauss-Seidel, up to eight passes): inelastic normal impulse, Coulomb friction
/// clamped to mu times it. A point that is pinched, pushed back by planes that look at each other, has no normal
/// velocity to stop: there the way it is pushed in the step stands for the normal impulse (for a point that rests or
/// lands it is no larger), so that jaws hold what they squeeze, however hard. Their squeeze itself is not reported as a
/// force: rigid jaws leave it undetermined. Not good at: stacks, in which an impulse has to travel further than eight
/// points.
class ImpulseContacts {
 public:
  static constexpr int kPasses = 8;  // contacts that share nodes push each other

  /// Puts the points of `contacts` back on their planes and stops their approach, after a step of `dt`. `drift` is the
  /// share of a velocity change in this step that also moves the nodes within it: 1 when x follows the new velocity, 0
  /// when it follows the old one. inverse_mass: 1/kg by node, 0 for prescribed nodes.
  /// One pass does where no two contacts share a node.
  void resolve(const ContactConstraints& contacts, const Eigen::VectorXd& inverse_mass, double dt, double drift,
               State* s, int passes = kPasses);
  /// N s on the body, of the last call, by contact.
  Vec3 impulse(size_t contact, const ContactConstraints& contacts) const {
    return points_[contact].normal * contacts[contact].normal + points_[contact].friction;
  }

 private:
  struct Point {
    double mass;    // effective mass of the point, kg; 0 when it cannot move
    double normal;  // accumulated impulse, N s
    Vec3 friction;  // accumulated impulse, N s
    double pushed;  // N s: the impulse that would have made its way back to the plane in this step
  };
  /// Whether there was anything to do.
  bool resolve(const ContactConstraint& c, const Eigen::VectorXd& inverse_mass, double dt, double drift, Point* point,
               State* s) const;

  std::vector<Point> points_;
};

}  // namespace deformable_sim
