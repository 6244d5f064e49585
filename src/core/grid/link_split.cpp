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

/// visit(|k_ij| (m_i m_j)^(-1/2) of all j, k_ij / m_i of all j) for the rows of a term.
template <class Visit>
void for_each_row(const ConstantLinks& links, const Eigen::VectorXd& mass, const Visit& visit) {
  std::vector<double> scaled, own;
  for (size_t row = 0; row < links.sum.size(); ++row) {
    const double m = mass[links.first_node + links.node[row]];
    scaled.clear();
    own.clear();
    for (int k = links.row_start[row]; k < links.row_start[row + 1]; ++k) {
      const auto e = static_cast<size_t>(k);
      if (links.stiffness[e] == 0.0) continue;
      const double other = mass[links.first_node + static_cast<int>(links.place[e] / 4)];
      scaled.push_back(std::abs(links.stiffness[e]) / std::sqrt(m * other));
      own.push_back(links.stiffness[e] / m);
    }
    visit(scaled, own);
  }
}

/// How many links are above `fastest`, how many below, and a bound of the eigenvalues of the latter [Gershgorin].
struct Shares {
  double fast = 0.0, slow = 0.0, bound = 0.0;
};
Shares shares_of(const std::vector<const ConstantLinks*>& links, const Eigen::VectorXd& mass, double fastest) {
  Shares shares;
  for (const ConstantLinks* term : links) {
    for_each_row(*term, mass, [&](const std::vector<double>& scaled, const std::vector<double>& own) {
      double sum = 0.0, beside = 0.0;
      for (size_t k = 0; k < scaled.size(); ++k) {
        if (scaled[k] > fastest) {
          shares.fast += 1.0;
        } else {
          shares.slow += 1.0;
          sum += own[k];
          beside += scaled[k];
        }
      }
      shares.bound = std::max(shares.bound, std::abs(sum) + beside);
    });
  }
  return shares;
}

}  // namespace

LinkSplit split_links(const std::vector<const ConstantLinks*>& links, const Eigen::VectorXd& mass, double part) {
  LinkSplit best;
  if (links.empty()) return best;
  const double damping = links.front()->damping, all = shares_of(links, mass, 0.0).fast;
  double least = all;
  double fastest = shares_of(links, mass, std::numeric_limits<double>::infinity()).bound;
  for (int k = 0; k < kTries; ++k, fastest *= kFiner) {
    const Shares shares = shares_of(links, mass, fastest);
    if (!(shares.bound > 0.0)) break;
    const double longest =
        std::min({kOfOscillation / std::sqrt(shares.bound), kOfDecay / (damping * shares.bound), kOfDamping * damping});
    const int together = std::min(kMostTogether, static_cast<int>(longest / part));
    if (together < 2) continue;
    const double cost = shares.fast + shares.slow / together;
    if (cost >= least) continue;
    least = cost;
    best = {fastest, together, longest};
  }
  return best;
}

}  // namespace deformable_sim
