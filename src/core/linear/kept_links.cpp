#include "deformable_sim/core/linear/kept_links.h"

#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kLeast = 0.01;

}  // namespace

/// visit(node, stiffness) for the links of a row that count.
template <class Visit>
void KeptLinks::for_each(const ConstantLinks& links, size_t row, const Visit& visit) const {
  const double least = kLeast * std::sqrt(std::abs(links.sum[row]));
  for (int e = links.row_start[row]; e < links.row_start[row + 1]; ++e) {
    const auto k = static_cast<size_t>(e);
    const int j = links.first_node + static_cast<int>(links.place[k] / 4);
    const double other = size_[static_cast<size_t>(j)];
    if (links.stiffness[k] != 0.0 && std::abs(links.stiffness[k]) >= least * other) visit(j, links.stiffness[k]);
  }
}

void KeptLinks::measure(size_t nodes) {
  size_.assign(nodes, 0.0);
  for (const ConstantLinks* links : links_) {
    for (size_t row = 0; row < links->sum.size(); ++row) {
      size_[static_cast<size_t>(links->first_node + links->node[row])] = std::sqrt(std::abs(links->sum[row]));
    }
  }
}

std::vector<int> KeptLinks::counts(size_t nodes) {
  measure(nodes);
  std::vector<int> counts(nodes, 0);
  for (const ConstantLinks* links : links_) {
    for (size_t row = 0; row < links->sum.size(); ++row) {
      int& count = counts[static_cast<size_t>(links->first_node + links->node[row])];
      for_each(*links, row, [&](int, double) { ++count; });
    }
  }
  return counts;
}

void KeptLinks::pack(const std::vector<int>& position, const std::vector<char>& held, int width) {
  const size_t nodes = position.size(), padded = (nodes + static_cast<size_t>(width) - 1) / static_cast<size_t>(width);
  measure(nodes);
  width_ = width;
  rows_.clear();
  value_.clear();
  sum_.assign(padded * static_cast<size_t>(width), 1.0f);
  to_held_.assign(nodes, {0.0f, 0.0f});
  if (links_.empty()) return;
  struct Link {
    int column;
    float stiffness, damping;
  };
  std::vector<std::vector<Link>> by_row(nodes);
  for (const ConstantLinks* links : links_) {
    for (size_t row = 0; row < links->sum.size(); ++row) {
      const auto p = static_cast<size_t>(position[static_cast<size_t>(links->first_node + links->node[row])]);
      if (held[p] != 0) continue;
      for_each(*links, row, [&](int j, double stiffness) {
        const int other = position[static_cast<size_t>(j)];
        const auto k = static_cast<float>(stiffness), c = static_cast<float>(links->damping * stiffness);
        if (held[static_cast<size_t>(other)] != 0) {
          to_held_[p][0] += k;
          to_held_[p][1] += c;
        } else {
          by_row[p].push_back({other, k, c});
        }
      });
    }
  }
  std::vector<int> length;
  for (const auto& row : by_row) length.push_back(static_cast<int>(row.size()));
  rows_.lay_out(length, width);
  stiffness_.assign(rows_.size(), 0.0f);
  damping_.assign(rows_.size(), 0.0f);
  value_.resize(rows_.size());
  for (size_t p = 0; p < nodes; ++p) {
    for (int k = 0; k < length[p]; ++k) {
      const Link& link = by_row[p][static_cast<size_t>(k)];
      const size_t at = rows_.at(static_cast<int>(p), k);
      rows_.set_column(static_cast<int>(p), k, link.column);
      stiffness_[at] = link.stiffness;
      damping_[at] = link.damping;
    }
  }
}

void KeptLinks::scale(double tau) {
  const auto rate = static_cast<float>(1.0 / tau);
  for (size_t k = 0; k < value_.size(); ++k) value_[k] = stiffness_[k] + rate * damping_[k];
  const auto width = static_cast<size_t>(width_);
  for (size_t p = 0; p < to_held_.size(); ++p) {
    const int offset = static_cast<int>(p) % width_;
    sum_[p - static_cast<size_t>(offset) + static_cast<size_t>(packet_lane(offset, width_))] =
        to_held_[p][0] + rate * to_held_[p][1];
  }
  for (int packet = 0; packet < rows_.packets(); ++packet) {
    float* sum = sum_.data() + static_cast<size_t>(packet) * width;
    for (int k = rows_.start(packet); k < rows_.start(packet + 1); ++k) {
      const float* value = value_.data() + static_cast<size_t>(k) * width;
      for (size_t lane = 0; lane < width; ++lane) sum[lane] += value[lane];
    }
  }
}

}  // namespace deformable_sim
