#include "deformable_sim/core/linear/block_factor.h"

#include <cmath>

#include <Eigen/SparseCholesky>

namespace deformable_sim {
namespace {

/// Scalar matrix with the pattern of `a` that has a Cholesky factor.
Eigen::SparseMatrix<double> pattern_matrix(const BlockMatrix& a) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(a.block_count()));
  for (int i = 0; i < a.rows(); ++i) {
    const int first = a.row_start()[static_cast<size_t>(i)], last = a.row_start()[static_cast<size_t>(i) + 1];
    for (int k = first; k < last; ++k) {
      const int j = a.column()[static_cast<size_t>(k)];
      entries.emplace_back(i, j, j == i ? static_cast<double>(last - first) : -1.0);
    }
  }
  Eigen::SparseMatrix<double> matrix(a.rows(), a.rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Inverse of the Cholesky factor of a 3 x 3 matrix; false when that is not positive definite.
bool inverse_factor(const Mat3& a, Mat3* inverse) {
  const double l00 = std::sqrt(a(0, 0)), l10 = a(1, 0) / l00, l20 = a(2, 0) / l00;
  const double d1 = a(1, 1) - l10 * l10, l11 = std::sqrt(d1), l21 = (a(2, 1) - l20 * l10) / l11;
  const double d2 = a(2, 2) - l20 * l20 - l21 * l21, l22 = std::sqrt(d2);
  if (!(a(0, 0) > 0.0) || !(d1 > 0.0) || !(d2 > 0.0)) return false;
  *inverse << 1.0 / l00, 0, 0, -l10 / (l00 * l11), 1.0 / l11, 0, (l10 * l21 / l11 - l20) / (l00 * l22),
      -l21 / (l11 * l22), 1.0 / l22;
  return true;
}

}  // namespace

void BlockFactor::analyse(const BlockMatrix& a) {
  const Eigen::SparseMatrix<double> matrix = pattern_matrix(a);
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(matrix);
  const auto& order = factor.permutationP().indices();
  const auto n = static_cast<size_t>(a.rows());
  position_.assign(order.data(), order.data() + order.size());
  std::vector<int> node(n);
  for (size_t i = 0; i < n; ++i) node[static_cast<size_t>(position_[i])] = static_cast<int>(i);

  source_.clear();
  source_start_.assign(1, 0);
  diagonal_slot_.resize(n);
  for (size_t p = 0; p < n; ++p) {
    const auto i = static_cast<size_t>(node[p]);
    diagonal_slot_[p] = a.diagonal_slot(node[p]);
    for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
      const int column = position_[static_cast<size_t>(a.column()[static_cast<size_t>(k)])];
      if (column < static_cast<int>(p)) source_.push_back({column, k});
    }
    source_start_.push_back(static_cast<int>(source_.size()));
  }

  const Eigen::SparseMatrix<double> lower = factor.matrixL();
  std::vector<std::vector<int>> rows(n);
  column_start_.assign(1, 0);
  for (int j = 0; j < a.rows(); ++j) {
    int length = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower, j); it; ++it) {
      if (it.row() == j) continue;
      ++length;
      rows[static_cast<size_t>(it.row())].push_back(j);
    }
    column_start_.push_back(column_start_.back() + length);
  }
  row_start_.assign(1, 0);
  row_column_.clear();
  for (const auto& row : rows) {
    row_column_.insert(row_column_.end(), row.begin(), row.end());
    row_start_.push_back(static_cast<int>(row_column_.size()));
  }
  column_fill_.resize(n);
  entry_row_.resize(row_column_.size());
  entry_.resize(row_column_.size());
  inverse_diagonal_.resize(n);
  work_.assign(n, Mat3::Zero());
  permuted_.resize(3, a.rows());
}

/// Row by row: L_k,1..k-1 solves a triangular system with the rows above it. Entries that are zero are not stored.
bool BlockFactor::factorise(const BlockMatrix& a) {
  std::copy(column_start_.begin(), column_start_.end() - 1, column_fill_.begin());
  Mat3* x = work_.data();
  for (size_t k = 0; k < position_.size(); ++k) {
    for (int s = source_start_[k]; s < source_start_[k + 1]; ++s) {
      const Source& source = source_[static_cast<size_t>(s)];
      x[source.column] = a.block(source.slot);
    }
    Mat3 diagonal = a.block(diagonal_slot_[k]);
    for (int r = row_start_[k]; r < row_start_[k + 1]; ++r) {
      const auto j = static_cast<size_t>(row_column_[static_cast<size_t>(r)]);
      if (x[j].isZero(0.0)) continue;
      const Mat3 value = x[j] * inverse_diagonal_[j].transpose();
      x[j].setZero();
      const int last = column_fill_[j]++;
      for (int e = column_start_[j]; e < last; ++e)
        x[entry_row_[static_cast<size_t>(e)]].noalias() -= value * entry_[static_cast<size_t>(e)];
      diagonal.noalias() -= value * value.transpose();
      entry_row_[static_cast<size_t>(last)] = static_cast<int>(k);
      entry_[static_cast<size_t>(last)] = value.transpose();
    }
    if (!inverse_factor(diagonal, &inverse_diagonal_[k])) {
      for (Mat3& block : work_) block.setZero();
      return false;
    }
  }
  return true;
}

void BlockFactor::solve(Nodes* x) {
  const auto n = static_cast<int>(position_.size());
  for (int i = 0; i < n; ++i) permuted_.col(position_[static_cast<size_t>(i)]) = x->col(i);
  for (int j = 0; j < n; ++j) {
    const auto column = static_cast<size_t>(j);
    const Vec3 pivot = inverse_diagonal_[column] * permuted_.col(j);
    permuted_.col(j) = pivot;
    for (int e = column_start_[column]; e < column_fill_[column]; ++e)
      permuted_.col(entry_row_[static_cast<size_t>(e)]).noalias() -= entry_[static_cast<size_t>(e)].transpose() * pivot;
  }
  for (int j = n - 1; j >= 0; --j) {
    const auto column = static_cast<size_t>(j);
    Vec3 sum = permuted_.col(j);
    for (int e = column_start_[column]; e < column_fill_[column]; ++e)
      sum.noalias() -= entry_[static_cast<size_t>(e)] * permuted_.col(entry_row_[static_cast<size_t>(e)]);
    permuted_.col(j).noalias() = inverse_diagonal_[column].transpose() * sum;
  }
  for (int i = 0; i < n; ++i) x->col(i) = permuted_.col(position_[static_cast<size_t>(i)]);
}

}  // namespace deformable_sim
