#include "deformable_sim/core/integrator/spring_chains.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace deformable_sim {
namespace {

constexpr double kTiny = 1e-12;  // m

/// Springs at each node, by term.
class Incidence {
 public:
  Incidence(const std::vector<KnownSpring>& springs, Eigen::Index nodes)
      : springs_(springs), at_(static_cast<size_t>(nodes)), used_(springs.size(), false) {
    for (size_t k = 0; k < springs.size(); ++k) {
      at_[static_cast<size_t>(springs[k].a)].push_back(static_cast<int>(k));
      at_[static_cast<size_t>(springs[k].b)].push_back(static_cast<int>(k));
    }
  }

  bool used(int spring) const { return used_[static_cast<size_t>(spring)]; }
  void use(int spring) { used_[static_cast<size_t>(spring)] = true; }
  int other_end(int spring, int node) const {
    const KnownSpring& s = springs_[static_cast<size_t>(spring)];
    return s.a == node ? s.b : s.a;
  }

  /// The spring by which a chain goes on that has come to `node` by `spring`; -1: none.
  int next(int spring, int node) const {
    const int step = node - other_end(spring, node), term = springs_[static_cast<size_t>(spring)].term;
    int degree = 0, straight = -1, any = -1;
    for (int k : at_[static_cast<size_t>(node)]) {
      if (springs_[static_cast<size_t>(k)].term != term) continue;
      ++degree;
      if (used(k)) continue;
      any = k;
      if (other_end(k, node) - node == step) straight = k;
    }
    return degree <= 2 ? any : straight;
  }

 private:
  const std::vector<KnownSpring>& springs_;
  std::vector<std::vector<int>> at_;
  std::vector<bool> used_;
};

}  // namespace

SpringChains::SpringChains(const std::vector<KnownSpring>& springs, Eigen::Index nodes, Grouping grouping) {
  start_.push_back(0);
  grouping == Grouping::kLines ? group_lines(springs, nodes) : group_singly(springs, nodes);
  tension_.assign(springs_.size(), 0.0);
  int longest = 0;
  for (size_t c = 1; c < start_.size(); ++c) longest = std::max(longest, start_[c] - start_[c - 1]);
  slots_.resize(static_cast<size_t>(longest));
}

/// Both ways from each spring that is left. A chain that comes back to itself ends there: its last spring is another.
void SpringChains::group_lines(const std::vector<KnownSpring>& springs, Eigen::Index nodes) {
  Incidence incidence(springs, nodes);
  std::vector<int> seen(static_cast<size_t>(nodes), -1);
  for (size_t first = 0; first < springs.size(); ++first) {
    if (incidence.used(static_cast<int>(first))) continue;
    std::vector<KnownSpring> chain;
    const auto walk = [&](int spring, int node) {
      while ((spring = incidence.next(spring, node)) >= 0) {
        const int end = incidence.other_end(spring, node);
        if (seen[static_cast<size_t>(end)] == static_cast<int>(first)) return;
        seen[static_cast<size_t>(end)] = static_cast<int>(first);
        incidence.use(spring);
        chain.push_back(springs[static_cast<size_t>(spring)]);
        chain.back().a = node;
        chain.back().b = node = end;
      }
    };
    const KnownSpring& begin = springs[first];
    seen[static_cast<size_t>(begin.a)] = seen[static_cast<size_t>(begin.b)] = static_cast<int>(first);
    incidence.use(static_cast<int>(first));
    walk(static_cast<int>(first), begin.a);
    for (KnownSpring& spring : chain) std::swap(spring.a, spring.b);
    std::reverse(chain.begin(), chain.end());
    chain.push_back(begin);
    walk(static_cast<int>(first), begin.b);
    springs_.insert(springs_.end(), chain.begin(), chain.end());
    start_.push_back(static_cast<int>(springs_.size()));
  }
}

void SpringChains::group_singly(const std::vector<KnownSpring>& springs, Eigen::Index nodes) {
  std::vector<std::uint64_t> taken(static_cast<size_t>(nodes), 0);
  std::vector<int> colour(springs.size(), 0);
  int colours = 0;
  for (size_t k = 0; k < springs.size(); ++k) {
    std::uint64_t& a = taken[static_cast<size_t>(springs[k].a)];
    std::uint64_t& b = taken[static_cast<size_t>(springs[k].b)];
    // Beyond 63 colours the last one is shared: what is solved one after the other needs none to be right.
    while (colour[k] < 63 && (((a | b) >> colour[k]) & 1u) != 0) ++colour[k];
    a |= std::uint64_t{1} << colour[k];
    b |= std::uint64_t{1} << colour[k];
    colours = std::max(colours, colour[k] + 1);
  }
  for (int c = 0; c < colours; ++c) {
    for (size_t k = 0; k < springs.size(); ++k) {
      if (colour[k] != c) continue;
      springs_.push_back(springs[k]);
      start_.push_back(static_cast<int>(springs_.size()));
    }
  }
}

void SpringChains::begin(double tau) {
  tau_ = tau;
  std::fill(tension_.begin(), tension_.end(), 0.0);
}

void SpringChains::sweep(const Eigen::VectorXd& weight, const Nodes& base, Nodes* x, Nodes* pull) {
  for (size_t c = 1; c < start_.size(); ++c) solve(start_[c - 1], start_[c], weight, base, x, pull);
}

/// Thomas' algorithm. With g = n'.n w of the node between two springs:
///   d_k = 1 + K_k (w_k + w_k+1 - g^2 K_k-1 / d_k-1),  s_k = (rhs_k + K_k g s_k-1) / d_k,  dt_k = s_k + K_k g' / d_k
///   dt_k+1
void SpringChains::solve(int first, int last, const Eigen::VectorXd& weight, const Nodes& base, Nodes* x, Nodes* pull) {
  double s_before = 0.0, ratio_before = 0.0;  // ratio: K / d
  Vec3 n_before = Vec3::Zero();
  for (int k = first; k < last; ++k) {
    const KnownSpring& spring = springs_[static_cast<size_t>(k)];
    const Vec3 d = x->col(spring.b) - x->col(spring.a);
    const double r = d.norm(), per_tau = spring.damping / tau_;
    const Vec3 n = r > kTiny ? Vec3(d / r) : Vec3::Zero();
    const double stiffness = r > kTiny ? spring.stiffness + per_tau : 0.0;
    double rhs = spring.stiffness * (r - spring.length) - tension_[static_cast<size_t>(k)];
    if (per_tau != 0.0) rhs += per_tau * n.dot(d - (base.col(spring.b) - base.col(spring.a)));
    if (stiffness == 0.0) rhs = -tension_[static_cast<size_t>(k)];
    const double meet = n.dot(n_before) * weight[spring.a], back = meet * ratio_before;
    const double inverse = 1.0 / (1.0 + stiffness * (weight[spring.a] + weight[spring.b] - meet * back));
    s_before = (rhs + stiffness * meet * s_before) * inverse;
    ratio_before = stiffness * inverse;
    slots_[static_cast<size_t>(k - first)] = {n, s_before, 0.0};
    if (k > first) slots_[static_cast<size_t>(k - first - 1)].back = back;
    n_before = n;
  }
  Vec3 beyond = Vec3::Zero();
  double change = 0.0;
  const auto apply = [&](int node, const Vec3& f) {
    if (weight[node] > 0.0) {
      x->col(node) += weight[node] * f;
    } else {
      pull->col(node) += f;
    }
  };
  for (int k = last - 1; k >= first; --k) {
    const Slot& slot = slots_[static_cast<size_t>(k - first)];
    change = slot.s + slot.back * change;
    tension_[static_cast<size_t>(k)] += change;
    const Vec3 own = change * slot.n;
    apply(springs_[static_cast<size_t>(k)].b, beyond - own);
    beyond = own;
  }
  if (last > first) apply(springs_[static_cast<size_t>(first)].a, beyond);
}

}  // namespace deformable_sim
