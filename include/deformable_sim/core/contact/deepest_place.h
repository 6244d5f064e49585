// Where an edge or a face of a sheet comes nearest to a convex shape.
#pragma once

#include <array>

#include "deformable_sim/core/contact/contact_points.h"
#include "deformable_sim/core/contact/surface_query.h"

namespace deformable_sim {

/// A point of an edge or face: p = sum weight_k x_k over the nodes of a ContactPoint.
struct Place {
  std::array<double, 3> weight{{1.0, 0.0, 0.0}};
  Vec3 p = Vec3::Zero();
  SurfacePoint surface;
};

/// The place of an edge (count 2) or face (3) nearest to the shape, or deepest in it, within 1/1000 of an edge, 1/128
/// of a face. The distance to a convex shape is convex along a line, so halving by the sign of n . (direction) finds
/// it: some 12 queries on an edge, up to 80 on a face. reach  m, of the middle: false when no place is nearer than that
/// less extent_of().
bool find_deepest_place(const ContactPoint& point, const Nodes& x, double reach, SurfaceQuery* shape, Place* found);

/// m, from the middle p to the furthest node.
double extent_of(const ContactPoint& point, const Vec3& middle, const Nodes& x);

}  // namespace deformable_sim
