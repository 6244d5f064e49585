// Where a ray is inside a convex shape, in closed form.
#pragma once

#include <limits>

#include "deformable_sim/core/contact/collider.h"

namespace deformable_sim {

/// Values of t with origin + t direction inside; empty when enter > leave.
struct RayInterval {
  double enter = std::numeric_limits<double>::infinity();
  double leave = -std::numeric_limits<double>::infinity();

  bool empty() const { return !(enter <= leave); }
};

/// Of a box, sphere, cylinder, capsule or cone, by its type and size; origin (m) and direction in the shape's frame,
/// the direction of any length but 0. Empty for other shapes.
RayInterval inside(const Shape& shape, const Vec3& origin, const Vec3& direction);

/// Half the edges (m) of the box around such a shape, centred on its origin.
Vec3 half_extents(const Shape& shape);

}  // namespace deformable_sim
