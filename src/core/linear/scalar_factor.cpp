#include "deformable_sim/core/linear/scalar_factor.h"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>

namespace deformable_sim {
namespace {

double largest_eigenvalue(const Mat3& block) {
  const Mat3 symmetric = 0.5 * (block + block.transpose());
  return Eigen::SelfAdjointEigenSolver<Mat3>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[2];
}

/// The scalar operator: graph Laplacian plus what the block rows do not cancel (mass, attachments, drag).
Eigen::SparseMatrix<double> scalar_operator(const BlockMatrix& a) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(a.block_count()));
  for (int i = 0; i < a.rows(); ++i) {
    Mat3 sum = Mat3::Zero();
    double diagonal = 0.0;
    for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
      const int j = a.column()[static_cast<size_t>(k)];
      sum += a.block(k);
      if (j == i) continue;
      const double weight = std::max(0.0, largest_eigenvalue(-a.block(k)));
      diagonal += weight;
      entries.emplace_back(i, j, -weight);
    }
    entries.emplace_back(i, i, diagonal + sum.trace() / 3.0);
  }
  Eigen::SparseMatrix<double> matrix(a.rows(), a.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

void ScalarFactor::compute(const BlockMatrix& a) {
  const Eigen::SparseMatrix<double> matrix = scalar_operator(a);
  diagonal_ = matrix.diagonal();
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
  const Eigen::SparseMatrix<double> lower = factor.matrixL();
  const auto& order = factor.permutationP().indices();
  position_.assign(order.data(), order.data() + order.size());

  column_start_.assign(1, 0);
  row_.clear();
  value_.clear();
  inverse_diagonal_.clear();
  for (int j = 0; j < lower.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (it.row() == j) {
        inverse_diagonal_.push_back(static_cast<float>(1.0 / it.value()));
      } else {
        row_.push_back(static_cast<int>(it.row()));
        value_.push_back(static_cast<float>(it.value()));
      }
    }
    column_start_.push_back(static_cast<int>(row_.size()));
  }
}

void ScalarFactor::solve(PaddedNodes* x, PaddedNodes* work) const {
  const int n = static_cast<int>(position_.size());
  for (int i = 0; i < n; ++i) work->col(position_[static_cast<size_t>(i)]) = x->col(i);
  for (int j = 0; j < n; ++j) {
    const Eigen::Vector4f pivot = inverse_diagonal_[static_cast<size_t>(j)] * work->col(j);
    work->col(j) = pivot;
    for (int k = column_start_[static_cast<size_t>(j)]; k < column_start_[static_cast<size_t>(j) + 1]; ++k) {
      work->col(row_[static_cast<size_t>(k)]) -= value_[static_cast<size_t>(k)] * pivot;
    }
  }
  for (int j = n - 1; j >= 0; --j) {
    Eigen::Vector4f sum = work->col(j);
    for (int k = column_start_[static_cast<size_t>(j)]; k < column_start_[static_cast<size_t>(j) + 1]; ++k) {
      sum -= value_[static_cast<size_t>(k)] * work->col(row_[static_cast<size_t>(k)]);
    }
    work->col(j) = inverse_diagonal_[static_cast<size_t>(j)] * sum;
  }
  for (int i = 0; i < n; ++i) x->col(i) = work->col(position_[static_cast<size_t>(i)]);
}

}  // namespace deformable_sim
