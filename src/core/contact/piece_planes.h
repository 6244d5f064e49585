// Planes that keep a point out of a solid bounded by convex pieces: triangles of a mesh, squares of a voxel solid.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "deformable_sim/core/contact/collider_mesh.h"

namespace deformable_sim {

/// Lengths in the units of the solid.
struct PlaneLimits {
  double clearance;  // that the point is kept from the surface
  double padding;    // by which the surface lies outside the pieces
  double least;      // below which a distance is rounding
};

/// How much of the room between a plane and the point above it a piece may take up and still be left out.
constexpr double kCoveredShare = 0.5;
/// Height above the surface, as a share of the clearance, from which the planes of a point inside are taken.
constexpr double kExitShare = 0.25;

/// Appends one plane for each of the pieces in `near`, from the nearest on, that no plane before has below it.
///
/// near           nearest points of the pieces in reach; it is sorted.
/// number_of(c)   number of a candidate's piece; ties are broken by it, and the planes come in its order.
/// facing(c)      the plane through the candidate with p on its outer side.
/// height(m, c)   of the piece above the plane m, negative below.
template <class Candidate, class Number, class Facing, class Height>
void gather_planes(const PlaneLimits& limits, const Number& number_of, const Facing& facing, const Height& height,
                   std::vector<Candidate>* near, std::vector<MeshPoint>* planes) {
  std::sort(near->begin(), near->end(), [&number_of](const Candidate& a, const Candidate& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                    : number_of(a) < number_of(b);
  });
  const std::size_t first = planes->size();
  for (const Candidate& candidate : *near) {
    bool covered = false;
    for (std::size_t k = first; k < planes->size() && !covered; ++k) {
      const MeshPoint& by = (*planes)[k];
      const double room = kCoveredShare * std::min(by.distance - limits.padding, limits.clearance);
      covered = height(by, candidate) <= std::max(room, limits.least);
    }
    if (!covered) planes->push_back(facing(candidate));
  }
  for (std::size_t k = first; k < planes->size(); ++k) (*planes)[k].distance -= limits.padding;
  std::sort(planes->begin() + static_cast<std::ptrdiff_t>(first), planes->end(),
            [](const MeshPoint& a, const MeshPoint& b) { return a.triangle < b.triangle; });
}

/// Planes of a point p at `surface` (padding taken off): from outside those of p, from inside those of the point a
/// little above the surface there.
///
/// exact(p, reach, &found)   nearest point of the pieces.
/// gather(p, reach)          gather_planes() at p.
template <class Exact, class Gather>
void planes_at(const Vec3& p, const MeshPoint& surface, double reach, const PlaneLimits& limits, const Exact& exact,
               const Gather& gather, std::vector<MeshPoint>* planes) {
  if (surface.distance > 0.0) return gather(p, reach);
  const double rise = std::max(kExitShare * limits.clearance, 10.0 * limits.least) - surface.distance;
  const Vec3 above = p + rise * surface.normal;
  MeshPoint there;
  if (!exact(above, limits.padding + rise + reach, &there) || there.distance <= limits.padding) {
    planes->push_back(surface);
    planes->back().triangle = std::max(0, surface.triangle);
    return;
  }
  const std::size_t first = planes->size();
  gather(above, reach + rise);
  for (std::size_t k = first; k < planes->size(); ++k) (*planes)[k].distance += (*planes)[k].normal.dot(p - above);
}

}  // namespace deformable_sim
