#include "deformable_sim/core/contact/cone_distance.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {

SurfacePoint cone_distance(const Vec3& p, double radius, double length) {
  // In the half-plane of p: from the axis, along z. The side runs from the rim up to the tip.
  using Vec2 = Eigen::Vector2d;
  const double away = std::hypot(p.x(), p.y());
  const Vec3 radial = away > 0.0 ? Vec3(p.x() / away, p.y() / away, 0.0) : Vec3::UnitX();
  const Vec2 at(away, p.z());
  const Vec2 rim(radius, -0.5 * length), tip(0.0, 0.5 * length);
  const Vec2 up_the_side = (tip - rim).normalized();
  Vec2 normal(up_the_side.y(), -up_the_side.x());
  const double beyond_side = normal.dot(at - rim);
  const double below_base = rim.y() - at.y();
  SurfacePoint found;
  if (beyond_side <= 0.0 && below_base <= 0.0) {  // inside: the nearer of the two
    found.distance = std::max(beyond_side, below_base);
    if (below_base > beyond_side) normal = Vec2(0.0, -1.0);
  } else if (below_base > 0.0 && away <= radius) {
    found.distance = below_base;
    normal = Vec2(0.0, -1.0);
  } else {
    const double along = std::clamp(up_the_side.dot(at - rim), 0.0, (tip - rim).norm());
    const Vec2 way = at - (rim + along * up_the_side);
    found.distance = way.norm();
    if (found.distance > 0.0) normal = way / found.distance;
  }
  found.normal = normal.x() * radial + normal.y() * Vec3::UnitZ();
  return found;
}

}  // namespace deformable_sim
