// Nearest points of the pieces that meshes are made of.
#pragma once

#include <array>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Weights of the two nearest points: those of the first piece's corners, then of the second's. Each set sums to 1.
struct ClosestPoints {
  std::array<double, 4> weight;
  Vec3 apart;  // m, from the nearest point of the second piece to that of the first
};

/// Of a point p and the triangle a b c: weights {p, a, b, c}. A triangle without area is its longest edge.
/// [Ericson 2004, Real-Time Collision Detection, 5.1.5: regions of the barycentric coordinates]
ClosestPoints closest_point_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Of the segments a b and c d: weights {a, b, c, d}. Where parallel ones overlap, the middle of what is common.
/// Segments without length are points. [Ericson 2004, 5.1.9]
ClosestPoints closest_segment_segment(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace deformable_sim
