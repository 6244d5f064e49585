// The friction spring of a contact: how far it gives, and what of its displacement it keeps.
#pragma once

#include "deformable_sim/core/contact/constraint.h"

namespace deformable_sim {

/// m: a sticking contact gives way this much before it slides, whatever it carries and however long the step is.
constexpr double kStickGive = 2e-5;

/// p = sum_k weight_k x_k, m.
Vec3 contact_position(const ContactConstraint& c, const Nodes& x);

/// `moved` (m), the displacement of a contact from where it stuck, without what the friction spring cannot hold: its
/// part in the plane, at most kStickGive long. Sliding drags the place where it sticks along.
Vec3 stick_remainder(const ContactConstraint& c, const Vec3& moved);

}  // namespace deformable_sim
