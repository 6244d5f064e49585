// Convex polygons cut by planes.
#pragma once

#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Corners of a convex, flat polygon in their order. Fewer than three: nothing.
using Polygon = std::vector<Vec3>;

struct CutPolygon {
  Polygon inside, outside;
};

/// The parts of a polygon on either side of a plane: inside where normal . x >= offset. Corners within `tolerance` (in
/// the unit of normal . x) count as on the plane, so that no sliver is cut off.
CutPolygon cut(const Polygon& polygon, const Vec3& normal, double offset, double tolerance);

}  // namespace deformable_sim
