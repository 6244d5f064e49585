#include "deformable_sim/core/linear/constant_factor.h"

namespace deformable_sim {

void ConstantFactor::factorise(const Eigen::SparseMatrix<double>& a) {
  factor_.compute(a);
  inverse_diagonal_ = factor_.vectorD().cwiseInverse();
  permuted_.resize(3, a.cols());
}

void ConstantFactor::solve(Nodes* x) {
  const Eigen::SparseMatrix<double>& lower = factor_.matrixL().nestedExpression();
  const int* start = lower.outerIndexPtr();
  const int* row = lower.innerIndexPtr();
  const double* value = lower.valuePtr();
  const auto& order = factor_.permutationP().indices();
  const Eigen::Index n = inverse_diagonal_.size();
  for (Eigen::Index i = 0; i < n; ++i) permuted_.col(order[i]) = x->col(i);
  double* w = permuted_.data();
  // Eigen keeps the strictly lower part alone.
  for (Eigen::Index j = 0; j < n; ++j) {
    const double x0 = w[3 * j], x1 = w[3 * j + 1], x2 = w[3 * j + 2];
    for (int e = start[j]; e < start[j + 1]; ++e) {
      double* to = w + 3 * static_cast<Eigen::Index>(row[e]);
      to[0] -= value[e] * x0;
      to[1] -= value[e] * x1;
      to[2] -= value[e] * x2;
    }
  }
  for (Eigen::Index j = n - 1; j >= 0; --j) {
    double x0 = inverse_diagonal_[j] * w[3 * j], x1 = inverse_diagonal_[j] * w[3 * j + 1],
           x2 = inverse_diagonal_[j] * w[3 * j + 2];
    for (int e = start[j]; e < start[j + 1]; ++e) {
      const double* from = w + 3 * static_cast<Eigen::Index>(row[e]);
      x0 -= value[e] * from[0];
      x1 -= value[e] * from[1];
      x2 -= value[e] * from[2];
    }
    w[3 * j] = x0;
    w[3 * j + 1] = x1;
    w[3 * j + 2] = x2;
  }
  for (Eigen::Index i = 0; i < n; ++i) x->col(i) = permuted_.col(order[i]);
}

}  // namespace deformable_sim
