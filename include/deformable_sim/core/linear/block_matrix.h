// Square sparse matrix of 3 x 3 blocks, one block row per node, fixed pattern.
#pragma once

#include <array>
#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Compressed block rows; every diagonal block exists, and (i, j) exists exactly when (j, i) does.
/// Not good at: changing its pattern (build a new one).
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// n block rows; `pairs` in any order, either orientation, repeats allowed. Rows from `first_scalar_row` on (-1:
  /// none) have one unknown, x; whoever fills the matrix leaves nothing but the diagonal in their y and z.
  BlockMatrix(int n, const std::vector<std::array<int, 2>>& pairs, int first_scalar_row = -1);

  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  int first_scalar_row() const { return first_scalar_row_; }
  int block_count() const { return static_cast<int>(column_.size()); }
  /// Index of block (i, j), or -1 outside the pattern.
  int slot(int i, int j) const;
  int diagonal_slot(int i) const { return diagonal_[static_cast<size_t>(i)]; }
  Mat3& block(int slot) { return blocks_[static_cast<size_t>(slot)]; }
  const Mat3& block(int slot) const { return blocks_[static_cast<size_t>(slot)]; }
  void set_zero();

  /// y = A x, columns are nodes.
  void multiply(const Nodes& x, Nodes* y) const;
  /// Scalar copy (3n x 3n, column-major).
  Eigen::SparseMatrix<double> to_sparse() const;

  const std::vector<int>& row_start() const { return row_start_; }
  const std::vector<int>& column() const { return column_; }

 private:
  int first_scalar_row_ = 0;
  std::vector<int> row_start_{0};
  std::vector<int> column_;
  std::vector<int> diagonal_;
  std::vector<Mat3> blocks_;
};

}  // namespace deformable_sim
