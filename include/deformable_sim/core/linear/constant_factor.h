// Cholesky factor of a sparse matrix that stays the same for many steps, for all three coordinates at once.
#pragma once

#include <vector>

#include <Eigen/SparseCholesky>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// A = P^T L D L^T P in double precision, minimum degree order. factorise() allocates, solve() does not.
class ConstantFactor {
 public:
  /// A n x n, symmetric positive definite; its lower triangle is read.
  void factorise(const Eigen::SparseMatrix<double>& a);
  bool empty() const { return inverse_diagonal_.size() == 0; }
  /// x := A^-1 x, x 3 x n.
  void solve(Nodes* x);

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  Eigen::VectorXd inverse_diagonal_;
  Nodes permuted_;
};

}  // namespace deformable_sim
