// What a step changes: time, positions and velocities of all nodes, and what some elements and schemes remember.
#pragma once

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// What the State holds of each segment of a rod with twist beside its ends: x and v of its angle's column, its
/// director and its reference twist.
using RodState = Eigen::Matrix<double, 6, Eigen::Dynamic>;

struct State {
  double time = 0.0;  // s
  Nodes x;            // 3 x n, m
  Nodes v;            // 3 x n, m/s

  // Rods with twist: the reference director of each segment, a unit vector normal to the unit tangent the segment had
  // when it was stored (the end of the last step). Empty without rods.
  Nodes directors, tangents;  // 3 x segments
  // ... and by how much the director of the next segment is turned against this one's, rad, unwrapped: 1 per segment.
  Eigen::VectorXd reference_twists;

  // Strain limits: what each carried in the last step, N. Empty without.
  Eigen::VectorXd limit_tension;

  // Multistep schemes: the state one step back. Empty for all others, and before the second step.
  Nodes x_before, v_before;
  // s, the step that led from there to here. One-step schemes that keep no x_before may keep a v_before of a uniform
  // acceleration: the one with which the last step ended. 0: it is not known.
  double dt_before = 0.0;

  /// What terms read beside time, x and v: a scheme that evaluates them at a state of its own calls this once a step.
  void copy_frames(const State& from) {
    if (from.directors.cols() == 0) return;
    directors = from.directors;
    tangents = from.tangents;
    reference_twists = from.reference_twists;
  }

  bool finite() const { return x.allFinite() && v.allFinite(); }
};

}  // namespace deformable_sim
