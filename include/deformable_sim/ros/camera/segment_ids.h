// Numbers for bodies and obstacles in segmented images: the same in all images of one scene.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Bodies are 1, 2, ... in the order of the scene. An obstacle or link gets the next number when it is first seen, and
/// again when one of its name comes back; when the numbers are used up, further ones share the last. Thread safe: the
/// cameras of a node have one together.
class SegmentIds {
 public:
  struct OfSnapshot {
    std::vector<std::uint16_t> bodies, colliders;  // parallel to those of the snapshot's
  };

  OfSnapshot of(const Snapshot& snapshot);

 private:
  std::mutex mutex_;
  std::map<std::string, std::uint16_t> colliders_;
};

}  // namespace deformable_sim
