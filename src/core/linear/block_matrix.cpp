#include "deformable_sim/core/linear/block_matrix.h"

#include <algorithm>
#include <cassert>

namespace deformable_sim {

BlockMatrix::BlockMatrix(int n, const std::vector<std::array<int, 2>>& pairs, int first_scalar_row)
    : first_scalar_row_(first_scalar_row < 0 ? n : first_scalar_row) {
  std::vector<std::array<int, 2>> entries;
  entries.reserve(2 * pairs.size() + static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) entries.push_back({i, i});
  for (const auto& p : pairs) {
    assert(p[0] >= 0 && p[0] < n && p[1] >= 0 && p[1] < n);
    entries.push_back({p[0], p[1]});
    entries.push_back({p[1], p[0]});
  }
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());

  row_start_.assign(static_cast<size_t>(n) + 1, 0);
  diagonal_.resize(static_cast<size_t>(n));
  column_.reserve(entries.size());
  for (const auto& e : entries) {
    if (e[0] == e[1]) diagonal_[static_cast<size_t>(e[0])] = static_cast<int>(column_.size());
    column_.push_back(e[1]);
    row_start_[static_cast<size_t>(e[0]) + 1] = static_cast<int>(column_.size());
  }
  blocks_.assign(column_.size(), Mat3::Zero());
}

int BlockMatrix::slot(int i, int j) const {
  const auto first = column_.begin() + row_start_[static_cast<size_t>(i)];
  const auto last = column_.begin() + row_start_[static_cast<size_t>(i) + 1];
  const auto found = std::lower_bound(first, last, j);
  return found != last && *found == j ? static_cast<int>(found - column_.begin()) : -1;
}

void BlockMatrix::set_zero() {
  std::fill(blocks_.begin(), blocks_.end(), Mat3::Zero());
}

void BlockMatrix::multiply(const Nodes& x, Nodes* y) const {
  const int n = rows();
  y->resize(3, n);
  for (int i = 0; i < n; ++i) {
    Vec3 sum = Vec3::Zero();
    for (int k = row_start_[static_cast<size_t>(i)]; k < row_start_[static_cast<size_t>(i) + 1]; ++k) {
      sum.noalias() += blocks_[static_cast<size_t>(k)] * x.col(column_[static_cast<size_t>(k)]);
    }
    y->col(i) = sum;
  }
}

Eigen::SparseMatrix<double> BlockMatrix::to_sparse() const {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * blocks_.size());
  for (int i = 0; i < rows(); ++i) {
    for (int k = row_start_[static_cast<size_t>(i)]; k < row_start_[static_cast<size_t>(i) + 1]; ++k) {
      const int j = column_[static_cast<size_t>(k)];
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) entries.emplace_back(3 * i + a, 3 * j + b, block(k)(a, b));
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(3 * rows(), 3 * rows());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace deformable_sim
