// What a step changes: time, positions and velocities of all nodes of the world.
#pragma once

#include "deformable_sim/core/types.h"

namespace deformable_sim {

struct State {
  double time = 0.0;  // s
  Nodes x;            // 3 x n, m
  Nodes v;            // 3 x n, m/s

  bool finite() const { return x.allFinite() && v.allFinite(); }
};

}  // namespace deformable_sim
