#include "deformable_sim/ros/camera/segment_ids.h"

#include <algorithm>

namespace deformable_sim {

namespace {

constexpr std::size_t kLast = 65535;

std::uint16_t number(std::size_t n) {
  return static_cast<std::uint16_t>(std::min(n, kLast));
}

}  // namespace

SegmentIds::OfSnapshot SegmentIds::of(const Snapshot& snapshot) {
  const std::lock_guard<std::mutex> lock(mutex_);
  OfSnapshot ids;
  const std::size_t bodies = snapshot.model->bodies.size();
  for (std::size_t i = 0; i < bodies; ++i) ids.bodies.push_back(number(i + 1));
  for (const Collider& collider : snapshot.colliders) {
    if (bodies + colliders_.size() < kLast) {
      colliders_.emplace(collider.name, number(bodies + colliders_.size() + 1));
    }
    const auto known = colliders_.find(collider.name);
    ids.colliders.push_back(known != colliders_.end() ? known->second : number(kLast));
  }
  return ids;
}

}  // namespace deformable_sim
