#include "deformable_sim/core/grid/mesh_packets.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/linear/row_order.h"

namespace deformable_sim {

template <class Real>
MeshPackets<Real>::MeshPackets(const Eigen::VectorXd& mass, const std::vector<MeshSpring>& springs,
                               const std::vector<const ConstantLinks*>& links, const LinkSplit& split, int width)
    : width_(width), index_(static_cast<size_t>(mass.size()), -1) {
  Rows sprung(index_.size()), fast(index_.size()), slow(index_.size());
  for (const MeshSpring& s : springs) {
    sprung[static_cast<size_t>(s.a)].push_back({s.b, s.stiffness, s.stiffness * s.length, s.damping});
    sprung[static_cast<size_t>(s.b)].push_back({s.a, s.stiffness, s.stiffness * s.length, s.damping});
  }
  for (const ConstantLinks* term : links) {
    shape_.links_damping = static_cast<Real>(term->damping);
    for (size_t row = 0; row < term->sum.size(); ++row) {
      const int own = term->first_node + term->node[row];
      for (int k = term->row_start[row]; k < term->row_start[row + 1]; ++k) {
        const auto e = static_cast<size_t>(k);
        if (term->stiffness[e] == 0.0) continue;
        const int other = term->first_node + static_cast<int>(term->place[e] / 4);
        const bool is_fast = std::abs(term->stiffness[e]) > split.fastest * std::sqrt(mass[own] * mass[other]);
        (is_fast ? fast : slow)[static_cast<size_t>(own)].push_back({other, term->stiffness[e], 0.0, 0.0});
      }
    }
  }
  for (Rows* rows : {&fast, &slow}) {
    for (size_t own = 0; own < rows->size(); ++own) {
      double sum = 0.0;
      for (const Row& entry : (*rows)[own]) sum += entry.value;
      if (!(*rows)[own].empty()) (*rows)[own].push_back({static_cast<int>(own), -sum, 0.0, 0.0});
    }
  }
  order(sprung, fast, slow);
  shape_.packets = (static_cast<int>(node_.size()) + width - 1) / width;
  springs_ = pack(sprung);
  fast_ = pack(fast);
  slow_ = pack(slow);
  shape_.springs = springs_.view();
  shape_.fast_links = fast_.view();
  shape_.slow_links = slow_.view();
  const bool damped = std::any_of(springs.begin(), springs.end(), [](const MeshSpring& s) { return s.damping != 0.0; });
  if (!damped) shape_.springs.damping = nullptr;
}

template <class Real>
void MeshPackets<Real>::order(const Rows& springs, const Rows& fast, const Rows& slow) {
  for (size_t start = 0; start < springs.size(); ++start) {
    if (index_[start] >= 0 || springs[start].empty()) continue;
    index_[start] = 0;
    size_t next = node_.size();
    for (node_.push_back(static_cast<int>(start)); next < node_.size(); ++next) {
      for (const Row& entry : springs[static_cast<size_t>(node_[next])]) {
        int& index = index_[static_cast<size_t>(entry.column)];
        if (index >= 0) continue;
        index = 0;
        node_.push_back(entry.column);
      }
    }
  }
  const auto count = [](const Rows& rows, int i) { return static_cast<long>(rows[static_cast<size_t>(i)].size()); };
  constexpr long kMany = 1024;
  sort_in_windows([&](int i) { return (count(fast, i) * kMany + count(springs, i)) * kMany + count(slow, i); }, &node_);
  for (size_t k = 0; k < node_.size(); ++k) index_[static_cast<size_t>(node_[k])] = static_cast<int>(k);
}

template <class Real>
typename MeshPackets<Real>::Entries MeshPackets<Real>::pack(const Rows& rows) const {
  Entries to;
  to.start.assign(1, 0);
  for (int packet = 0; packet < shape_.packets; ++packet) {
    const auto first = static_cast<size_t>(packet * width_), last = first + static_cast<size_t>(width_);
    const auto row = [&](size_t i) { return i < node_.size() ? &rows[static_cast<size_t>(node_[i])] : nullptr; };
    size_t longest = 0;
    for (size_t i = first; i < std::min(last, node_.size()); ++i) longest = std::max(longest, row(i)->size());
    for (size_t k = 0; k < longest; ++k) {
      for (size_t i = first; i < last; ++i) {
        const bool exists = row(i) != nullptr && k < row(i)->size();
        const Row entry = exists ? (*row(i))[k] : Row{0, 0.0, 0.0, 0.0};
        to.place.push_back(4 * (exists ? index(entry.column) : static_cast<int>(i)));
        to.value.push_back(static_cast<Real>(entry.value));
        to.rest.push_back(static_cast<Real>(entry.rest));
        to.damping.push_back(static_cast<Real>(entry.damping));
      }
    }
    to.start.push_back(to.start.back() + static_cast<int>(longest));
  }
  return to;
}

template <class Real>
MeshEntries<Real> MeshPackets<Real>::Entries::view() const {
  return {start.data(), place.data(), value.data(), rest.data(), damping.data()};
}

template class MeshPackets<float>;
template class MeshPackets<double>;

}  // namespace deformable_sim
