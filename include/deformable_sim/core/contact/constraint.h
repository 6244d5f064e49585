// Contacts of one step as planes: all a time scheme needs to know of colliders. No FCL here.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// A material point of a body that may not cross a plane during this step, or two that may not come closer.
///
/// Against a collider: p = sum_k weight[k] x[node[k]] (one node, a segment midpoint, or a face centroid), the weights
/// sum to 1, and `offset` already contains the contact radius; the plane is taken at the END of the step. Between two
/// bodies, or two places of one: p is the difference of two material points, the weights sum to 0, and `offset` is the
/// distance they keep.
/// Admissible: gap(p) = normal . p - offset >= 0. Valid for one step only (speculative contact, see
/// doc/theory/contact.md).
struct ContactConstraint {
  std::array<int, 4> node{{-1, -1, -1, -1}};     // world node indices; first `count` are used
  std::array<double, 4> weight{{1.0, 0, 0, 0}};  // sum to 1, or to 0
  int count = 1;
  Vec3 normal = Vec3::UnitZ();           // out of the collider
  double offset = 0.0;                   // m
  Vec3 surface_velocity = Vec3::Zero();  // m/s of the collider, as a rigid body, at the point
  double friction = 0.0;                 // Coulomb coefficient of this pair
  int collider = -1;                     // index into the world's colliders; -1: another body of the world
  Vec3 force = Vec3::Zero();             // N on the body, written by the integrator: normal + friction
  // m, tangential, world axes: how far the point is from where it stuck. In: before the step, turned with the collider
  // (StickMemory). Out, from schemes whose friction is a spring: after it (stick_remainder, contact/stick.h).
  Vec3 stuck = Vec3::Zero();
};

using ContactConstraints = std::vector<ContactConstraint>;

}  // namespace deformable_sim
