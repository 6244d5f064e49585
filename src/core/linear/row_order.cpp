#include "deformable_sim/core/linear/row_order.h"

namespace deformable_sim {

std::vector<int> breadth_first(const std::vector<std::vector<int>>& neighbours) {
  const auto degree = [&](int i) { return neighbours[static_cast<size_t>(i)].size(); };
  std::vector<int> starts(neighbours.size()), order, next;
  for (size_t i = 0; i < starts.size(); ++i) starts[i] = static_cast<int>(i);
  std::stable_sort(starts.begin(), starts.end(), [&](int i, int j) { return degree(i) < degree(j); });
  std::vector<char> seen(starts.size(), 0);
  for (int start : starts) {
    if (seen[static_cast<size_t>(start)] != 0) continue;
    seen[static_cast<size_t>(start)] = 1;
    order.push_back(start);
    for (size_t k = order.size() - 1; k < order.size(); ++k) {
      next.clear();
      for (int j : neighbours[static_cast<size_t>(order[k])]) {
        if (seen[static_cast<size_t>(j)] != 0) continue;
        seen[static_cast<size_t>(j)] = 1;
        next.push_back(j);
      }
      std::stable_sort(next.begin(), next.end(), [&](int p, int q) { return degree(p) < degree(q); });
      order.insert(order.end(), next.begin(), next.end());
    }
  }
  return order;
}

}  // namespace deformable_sim
