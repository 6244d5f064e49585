// Signed distance to a solid cone, in closed form: FCL answers for cones by iteration, with wrong depths.
#pragma once

#include "deformable_sim/core/contact/surface_query.h"

namespace deformable_sim {

/// The cone stands along z, centred: its base of `radius` (m, > 0) at z = -length / 2, its tip at z = length / 2.
/// p and the normal are in the cone's frame. On the axis, where no direction is nearest, the normal leans to +x.
SurfacePoint cone_distance(const Vec3& p, double radius, double length);

}  // namespace deformable_sim
