// In which order loops over sparse rows run.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace deformable_sim {

/// Sorts `rows` by length(row), a few hundred at a time: a processor foresees the ends of loops of equal lengths, and
/// neighbours stay near each other.
template <class Length>
void sort_in_windows(const Length& length, std::vector<int>* rows) {
  constexpr std::ptrdiff_t kWindow = 256;
  for (auto first = rows->begin(); first != rows->end();) {
    const auto last = first + std::min(kWindow, rows->end() - first);
    std::stable_sort(first, last, [&](int i, int j) { return length(i) < length(j); });
    first = last;
  }
}

/// Nodes breadth first from a node of least degree, so that neighbours lie near each other in memory [Cuthill 1969].
std::vector<int> breadth_first(const std::vector<std::vector<int>>& neighbours);

}  // namespace deformable_sim
