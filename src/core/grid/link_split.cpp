#include "deformable_sim/core/grid/link_split.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {
namespace {

constexpr int kMostTogether = 8;
constexpr double kOfOscillation = 0.15, kOfDecay = 0.25, kOfDamping = 1.0;
constexpr double kFiner = 0.7;  // from one `fastest` that is tried to the next
constexpr int kTries = 20;

/// Links by rows: |k_ij| (m_i m_j)^(-1/2), and k_ij / m_i.
struct Scaled {
  std::vector<size_t> start{0};
  std::vector<double> beside, own;
};
Scaled scaled(const std::vector<const ConstantLinks*>& links, const Eigen::VectorXd& mass) {
  const Eigen::VectorXd root = mass.cwiseSqrt().cwiseInverse();
  Scaled all;
  for (const ConstantLinks* term : links) {
    for (size_t row = 0; row < term->sum.size(); ++row) {
      const double mine = root[term->first_node + term->node[row]];
      for (int k = term->row_start[row]; k < term->row_start[row + 1]; ++k) {
        const auto e = static_cast<size_t>(k);
        if (term->stiffness[e] == 0.0) continue;
        const double other = root[term->first_node + static_cast<int>(term->place[e] / 4)];
        all.beside.push_back(std::abs(term->stiffness[e]) * mine * other);
        all.own.push_back(term->stiffness[e] * mine * mine);
      }
      all.start.push_back(all.own.size());
    }
  }
  return all;
}

/// How many links are above `fastest`, and a bound of the eigenvalues of all others (Gershgorin).
struct Shares {
  size_t fast = 0;
  double bound = 0.0;
};
Shares shares_of(const Scaled& links, double fastest) {
  Shares shares;
  for (size_t row = 0; row + 1 < links.start.size(); ++row) {
    double sum = 0.0, beside = 0.0;
    for (size_t k = links.start[row]; k < links.start[row + 1]; ++k) {
      const bool fast = links.beside[k] > fastest;
      shares.fast += fast ? 1 : 0;
      sum += fast ? 0.0 : links.own[k];
      beside += fast ? 0.0 : links.beside[k];
    }
    shares.bound = std::max(shares.bound, std::abs(sum) + beside);
  }
  return shares;
}

}  // namespace

LinkSplit split_links(const std::vector<const ConstantLinks*>& links, const Eigen::VectorXd& mass, double part) {
  LinkSplit best;
  if (links.empty()) return best;
  const Scaled all = scaled(links, mass);
  const double damping = links.front()->damping;
  auto least = static_cast<double>(all.own.size());
  double fastest = shares_of(all, std::numeric_limits<double>::infinity()).bound;
  for (int k = 0; k < kTries; ++k, fastest *= kFiner) {
    const Shares shares = shares_of(all, fastest);
    if (!(shares.bound > 0.0)) break;
    const double longest =
        std::min({kOfOscillation / std::sqrt(shares.bound), kOfDecay / (damping * shares.bound), kOfDamping * damping});
    const int together = std::min(kMostTogether, static_cast<int>(longest / part));
    if (together < 2) continue;
    const auto fast = static_cast<double>(shares.fast);
    const double cost = fast + (static_cast<double>(all.own.size()) - fast) / together;
    if (cost >= least) continue;
    least = cost;
    best = {fastest, together, longest};
  }
  return best;
}

}  // namespace deformable_sim
