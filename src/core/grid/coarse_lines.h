// Lines of nodes and those of half as many, which every other node of the finer line lies on.
#pragma once

#include <array>

namespace deformable_sim {

/// Which coarse nodes of a line a fine one is interpolated from, linearly.
struct Parents {
  int node[2];
  double weight[2];
  int count;
};
inline Parents parents(int k, bool halves) {
  if (!halves) return {{k, 0}, {1.0, 0.0}, 1};
  if (k % 2 == 0) return {{k / 2, 0}, {1.0, 0.0}, 1};
  return {{k / 2, k / 2 + 1}, {0.5, 0.5}, 2};
}

/// Rows and columns from a node to itself and to its neighbours of higher index, in the order of Stencil entries.
inline constexpr std::array<std::array<int, 2>, 5> kNeighbours{{{0, 0}, {0, 1}, {1, -1}, {1, 0}, {1, 1}}};

}  // namespace deformable_sim
