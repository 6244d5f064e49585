// Rows of constant links from weights.
#include "deformable_sim/core/energy/shell_terms.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "deformable_sim/core/linear/row_order.h"

namespace deformable_sim {

ConstantLinks make_constant_links(const std::vector<QuadraticWeight>& weights, double damping, int first_node) {
  ConstantLinks links;
  links.damping = damping;
  links.first_node = first_node;
  int nodes = 0;
  for (const QuadraticWeight& w : weights) nodes = std::max({nodes, w.a + 1, w.b + 1});
  std::vector<std::vector<std::pair<int, double>>> rows(static_cast<size_t>(nodes));
  for (const QuadraticWeight& w : weights) {
    rows[static_cast<size_t>(w.a)].emplace_back(w.b, w.weight);
    rows[static_cast<size_t>(w.b)].emplace_back(w.a, w.weight);
  }
  links.node.resize(rows.size());
  std::iota(links.node.begin(), links.node.end(), 0);
  sort_in_windows([&](int i) { return static_cast<int>((rows[static_cast<size_t>(i)].size() + 3) / 4); }, &links.node);
  for (int i : links.node) {
    double sum = 0.0;
    for (const auto& [j, weight] : rows[static_cast<size_t>(i)]) {
      links.place.push_back(4U * static_cast<unsigned>(j));
      links.stiffness.push_back(weight);
      sum += weight;
    }
    links.sum.push_back(sum);
    while (links.place.size() % 4 != 0) {
      links.place.push_back(4U * static_cast<unsigned>(i));
      links.stiffness.push_back(0.0);
    }
    links.row_start.push_back(static_cast<int>(links.place.size()));
  }
  return links;
}

}  // namespace deformable_sim
