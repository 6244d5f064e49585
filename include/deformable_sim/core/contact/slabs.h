// Extents of moving things along a few fixed directions: what lies apart along one of them cannot meet.
#pragma once

#include <cstdint>
#include <cstring>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// One whole number for each of eight directions (unit_directions()). A vector of the compiler's: every processor this
/// package runs on takes one, or few, instructions for all eight.
using Lanes = std::int16_t __attribute__((vector_size(16)));

/// Numbers in Lanes are within +- this, so that differences of two of them are numbers as well.
constexpr int kMostLane = 15000;

/// 8 x 3, rows of length 1: the axes, the four diagonals of a cube, and one of a square.
const Eigen::Matrix<double, 8, 3>& unit_directions();

inline Lanes least(const Lanes& a, const Lanes& b) {
  return a < b ? a : b;
}
inline Lanes most(const Lanes& a, const Lanes& b) {
  return a > b ? a : b;
}
inline Lanes all_lanes(int value) {
  const auto v = static_cast<std::int16_t>(value);
  return Lanes{v, v, v, v, v, v, v, v};
}

/// Extent of a set of points at the start and at the end of a step, in steps of a length of the owner's choice. Points
/// move along straight lines, evenly.
struct Slabs {
  Lanes low_start, high_start, low_end, high_end;

  void extend(const Lanes& start, const Lanes& end) {
    low_start = least(low_start, start);
    high_start = most(high_start, start);
    low_end = least(low_end, end);
    high_end = most(high_end, end);
  }
  void extend(const Slabs& other) {
    low_start = least(low_start, other.low_start);
    high_start = most(high_start, other.high_start);
    low_end = least(low_end, other.low_end);
    high_end = most(high_end, other.high_end);
  }
  void inflate(const Lanes& start, const Lanes& end) {
    low_start -= start;
    high_start += start;
    low_end -= end;
    high_end += end;
  }
};

/// More than this counts as apart.
struct Gaps {
  Lanes start, end;
};

/// Whether along one direction a and b are further apart than the gaps, at the start and at the end and on the same
/// side: then at every moment between as well, for each corner moves evenly.
inline bool apart(const Slabs& a, const Slabs& b, const Gaps& gaps) {
  const auto above = (a.low_start - b.high_start > gaps.start) & (a.low_end - b.high_end > gaps.end);
  const auto below = (b.low_start - a.high_start > gaps.start) & (b.low_end - a.high_end > gaps.end);
  const auto either = above | below;
  std::uint64_t bits[2];
  static_assert(sizeof bits == sizeof either, "eight lanes of 16 bits");
  std::memcpy(bits, &either, sizeof bits);
  return (bits[0] | bits[1]) != 0;
}

}  // namespace deformable_sim
