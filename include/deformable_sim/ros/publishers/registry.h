// The list of all outputs.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/ros/publishers/publisher.h"

namespace deformable_sim {

/// Which rate an output follows: a parameter, or a fixed one.
enum class Rate { kMarkers, kPoints, kState, kHandles, kDiagnostics };

struct PublisherEntry {
  Rate rate;
  bool repeats;  // shown about once a second (wall) even while nothing changes
  std::unique_ptr<Publisher> (*make)(const PublisherContext& context);
};

const std::vector<PublisherEntry>& publisher_registry();

}  // namespace deformable_sim
