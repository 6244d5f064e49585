// Lanczos' method for one eigenvalue.
#pragma once

#include <cmath>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// When Lanczos' method ends.
struct LanczosPatience {
  int check_every;
  double change;  // of the eigenvalue between two checks, relative
};
constexpr LanczosPatience kFineLanczos{10, 1e-4}, kRoughLanczos{5, 2e-2};

/// Fixed pseudo-random numbers in [-1, 1]: no direction is left out, and every call gives the same bits.
Nodes lanczos_start(Eigen::Index n);

/// Largest eigenvalue of the tridiagonal matrix with these on its diagonal and beside it; the last of beta is unused.
double largest_of_tridiagonal(const std::vector<double>& alpha, const std::vector<double>& beta);

/// Largest eigenvalue of a symmetric operator `times`: Nodes -> Nodes, from a start q that it maps into its own space;
/// 0 for a start of zero.
template <class Times>
double largest_eigenvalue(Times&& times, Nodes q, LanczosPatience patience) {
  constexpr int kMostSteps = 200;
  if (!(q.norm() > 0.0)) return 0.0;
  q /= q.norm();
  Nodes last = Nodes::Zero(3, q.cols());
  std::vector<double> alpha, beta;
  double found = 0.0;
  for (int k = 1; k <= kMostSteps; ++k) {
    Nodes next = times(q);
    alpha.push_back(next.cwiseProduct(q).sum());
    next -= alpha.back() * q;
    if (k > 1) next -= beta.back() * last;
    const double norm = next.norm();
    const bool exhausted = norm <= 1e-6 * std::abs(alpha.front()) || norm == 0.0;
    if (exhausted || k % patience.check_every == 0) {
      const double largest = largest_of_tridiagonal(alpha, beta);
      const bool settled = std::abs(largest - found) <= patience.change * std::abs(largest);
      found = largest;
      if (exhausted || settled) break;
    }
    beta.push_back(norm);
    last = q;
    q = next / norm;
  }
  return found;
}

}  // namespace deformable_sim
