// Exact solution of one narrow part of a matrix, in a time that grows with its length only.
#pragma once

#include <memory>

#include "band_order.h"
#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {

/// A = L D L^T without pivoting, in scalars, eliminated from both ends at once: the two do not meet before the middle,
/// a dense matrix of at most bandwidth + 1 groups, so that they fill the two lanes of a register.
class BandFactor {
 public:
  virtual ~BandFactor() = default;
  /// Factorises A and solves A x = b in one sweep there and one back. Not definite: some pivot is not positive, x is as
  /// good as rounding lets it be. Not solved: x is zero. Never allocates.
  virtual LinearReport solve(const BlockMatrix& a, const Nodes& b, Nodes* x) = 0;
  /// x := A^-1 b with the last factors.
  virtual void solve_again(const Nodes& b, Nodes* x) = 0;
};

constexpr int kWidestBand = 8;  // groups

/// Of a part with a bandwidth up to kWidestBand.
std::unique_ptr<BandFactor> make_band_factor(const BlockMatrix& pattern, const BandPart& part);

}  // namespace deformable_sim
