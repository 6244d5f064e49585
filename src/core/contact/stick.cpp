#include "deformable_sim/core/contact/stick.h"

namespace deformable_sim {

Vec3 contact_position(const ContactConstraint& c, const Nodes& x) {
  Vec3 p = Vec3::Zero();
  for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) p += c.weight[k] * x.col(c.node[k]);
  return p;
}

Vec3 stick_remainder(const ContactConstraint& c, const Vec3& moved) {
  const Vec3 u = moved - c.normal.dot(moved) * c.normal;
  const double size = u.norm();
  return size > kStickGive ? Vec3(kStickGive / size * u) : u;
}

}  // namespace deformable_sim
