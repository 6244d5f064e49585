// Which parts of a matrix are narrow bands, and in which order.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/linear/block_matrix.h"

namespace deformable_sim {

/// A connected part of a pattern, in an order in which what couples lies close together.
struct BandPart {
  /// Block rows a group: a point alone, or with a row of one unknown beside it (-1: none).
  std::vector<std::array<int, 2>> group;
  bool has_scalars = false;
  int bandwidth = 0;  // coupled groups are at most so many places apart
};

struct BandParts {
  std::vector<BandPart> parts;
  std::vector<int> others;  // block rows of all parts wider than `widest`, ascending
};

/// Parts of bandwidth `widest` or less. Order: Cuthill and McKee's, from an end of the part [Cuthill 1969]; a closed
/// loop is folded in two by it. Rows of one unknown join the first free group that they couple with. Not good at:
/// finding the least bandwidth of anything but lines and strips.
BandParts band_parts(const BlockMatrix& pattern, int widest);

}  // namespace deformable_sim
