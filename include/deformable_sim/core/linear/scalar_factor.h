// Cholesky factor of a scalar n x n operator, applied to three right-hand sides at once in single precision.
#pragma once

#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/linear/block_matrix.h"

namespace deformable_sim {

/// One column per node: x, y, z and a padding lane, so that a node is one SIMD register.
using PaddedNodes = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// P A P^T = L L^T of the scalar operator that is nearest to a block matrix: off-diagonal entries are minus the largest
/// eigenvalue of -A_ij, row sums a third of the trace of the block row sums.
class ScalarFactor {
 public:
  /// Factorises; the previous factor is forgotten.
  void compute(const BlockMatrix& a);
  /// x := (L L^T)^-1 x, permuted as needed; `work` has the size of x.
  void solve(PaddedNodes* x, PaddedNodes* work) const;
  /// Diagonal of the scalar operator.
  const Eigen::VectorXd& diagonal() const { return diagonal_; }

 private:
  Eigen::VectorXd diagonal_;
  std::vector<int> position_;  // of node i in the elimination order
  // Strictly lower part of L by columns, and 1 / L_jj.
  std::vector<int> column_start_, row_;
  std::vector<float> value_, inverse_diagonal_;
};

}  // namespace deformable_sim
