// Prescribed motion of one step: all a time scheme needs to know of grasps.
#pragma once

#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Nodes whose motion is prescribed during a step (rigid grasps, pins).
struct Kinematics {
  std::vector<int> node;  // world node indices, ascending, each once
  Nodes target;           // 3 x node.size(): position at the end of the step, m
  Nodes reaction;         // 3 x node.size(), N the holder exerts on the node: m a - f; written by the integrator
};

}  // namespace deformable_sim
