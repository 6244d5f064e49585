#include "deformable_sim/core/contact/stick_memory.h"

#include <utility>

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

void StickMemory::begin_step() {
  if (remembered_ == Remembered::kOfLastPart) std::swap(start_, last_);
  remembered_ = Remembered::kOfStart;
}

void StickMemory::restart() {
  remembered_ = Remembered::kOfStart;
  stored_.clear();
}

void StickMemory::forget() {
  start_.clear();
  restart();
}

void StickMemory::end_part() {
  std::swap(last_, stored_);
  stored_.clear();
  remembered_ = Remembered::kOfLastPart;
}

}  // namespace deformable_sim
