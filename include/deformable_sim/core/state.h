// What a step changes: time, positions and velocities of all nodes, and what some elements and schemes remember.
#pragma once

#include "deformable_sim/core/types.h"

namespace deformable_sim {

struct State {
  double time = 0.0;  // s
  Nodes x;            // 3 x n, m
  Nodes v;            // 3 x n, m/s

  // Rods with twist: the reference director of each segment, a unit vector normal to the unit tangent the segment had
  // when it was stored (the end of the last step). Empty without rods.
  Nodes directors, tangents;  // 3 x segments

  // Multistep schemes: the state one step back. Empty for all others, and before the second step.
  Nodes x_before, v_before;
  double dt_before = 0.0;  // s, the step that led from there to here

  bool finite() const { return x.allFinite() && v.allFinite(); }
};

}  // namespace deformable_sim
