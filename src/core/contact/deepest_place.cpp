#include "deformable_sim/core/contact/deepest_place.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr int kEdgeHalvings = 10, kFaceHalvings = 7;

/// Where on the way from a to b the distance is least.
struct Least {
  double share = 0.0;
  Vec3 p = Vec3::Zero();
  SurfacePoint surface;
};

/// Halves [0, 1] by the sign of the slope that `look` returns for a share, having noted what it saw.
template <class Look>
void halve(int times, const Look& look) {
  double low = 0.0, high = 1.0;
  if (look(high) <= 0.0) return;
  for (int k = 0; k < times; ++k) {
    const double middle = 0.5 * (low + high);
    (look(middle) > 0.0 ? high : low) = middle;
  }
}

Least least_between(const Vec3& a, const Vec3& b, int halvings, double reach, SurfaceQuery* shape) {
  Least best;
  best.surface.distance = reach;
  const Vec3 way = b - a;
  halve(halvings, [&](double share) {
    Least next;
    next.share = share;
    next.p = a + share * way;
    if (shape->find(next.p, reach, &next.surface) && next.surface.distance < best.surface.distance) best = next;
    return next.surface.normal.dot(way);
  });
  return best;
}

}  // namespace

bool find_deepest_place(const ContactPoint& point, const Nodes& x, double reach, SurfaceQuery* shape, Place* found) {
  const Vec3 middle = position(point, x);
  if (!shape->find(middle, reach, &found->surface)) return false;
  // From anywhere on it the surface is within so much.
  const double extent = extent_of(point, middle, x), wide = reach + 2.0 * extent;
  const Vec3 a = x.col(point.node[0]), b = x.col(point.node[1]);
  Least best;
  if (point.count == 2) {
    best = least_between(a, b, kEdgeHalvings, wide, shape);
    found->weight = {{1.0 - best.share, best.share, 0.0}};
  } else {
    // On the lines from the first corner to places of the opposite edge: the least over such places, as a function of
    // how far along, is convex, too, and its slope is that of the distance with the place held.
    const Vec3 c = x.col(point.node[2]);
    best.surface.distance = wide;
    double along = 0.0;
    halve(kFaceHalvings, [&](double share) {
      const Least next = least_between(a + share * (b - a), a + share * (c - a), kFaceHalvings, wide, shape);
      if (next.surface.distance < best.surface.distance) {
        best = next;
        along = share;
      }
      return next.surface.normal.dot(b + next.share * (c - b) - a);
    });
    found->weight = {{1.0 - along, along * (1.0 - best.share), along * best.share}};
  }
  found->p = best.p;
  found->surface = best.surface;
  return found->surface.distance <= reach - extent;
}

double extent_of(const ContactPoint& point, const Vec3& middle, const Nodes& x) {
  double furthest = 0.0;
  for (size_t k = 0; k < static_cast<size_t>(point.count); ++k)
    furthest = std::max(furthest, (x.col(point.node[k]) - middle).squaredNorm());
  return std::sqrt(furthest);
}

}  // namespace deformable_sim
