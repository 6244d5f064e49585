// A chain of nodes at rest: open, or closed into a loop. Immutable once built.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

struct Polyline {
  Nodes rest;  // 3 x n, m
  bool closed = false;

  int segment_count() const { return static_cast<int>(rest.cols()) - (closed ? 0 : 1); }
  /// End nodes of segment s.
  std::array<int, 2> segment(int s) const { return {s, (s + 1) % static_cast<int>(rest.cols())}; }
};

/// Straight chain along +x, centred on the origin: `segments` >= 1, length > 0 (m).
Polyline make_line(double length, int segments);

/// Regular polygon in the x-y plane whose perimeter is `length` (m): `segments` >= 3 nodes, closed.
Polyline make_ring(double length, int segments);

}  // namespace deformable_sim
