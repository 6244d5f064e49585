// Cholesky factors of three scalar n x n operators, one an axis, applied at once in single precision.
#pragma once

#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/linear/block_matrix.h"

namespace deformable_sim {

/// One column per node: x, y, z and a padding lane, so that a node is one SIMD register.
using PaddedNodes = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// One value a node and axis, padded like PaddedNodes.
using AxisValues = Eigen::Matrix<float, 4, Eigen::Dynamic>;

/// Three scalar operators, one an axis, nearest to a block matrix: the same graph Laplacian (off-diagonal entries are
/// minus half the norm of A_ij) plus what the block rows do not cancel on that axis (mass, contacts,
/// attachments). They differ in their diagonals only, so that one elimination order and one sweep serve all three.
///
/// Not good at: constraints along directions between the axes, which it sees as weaker ones along the axes.
class ScalarFactor {
 public:
  /// Takes over the Laplacian; the elimination order only when the pattern is a new one. The factor comes with
  /// refresh().
  void prepare(const BlockMatrix& a);
  /// Factorises anew if the row sums of `a` have moved away from those of the present factor. Never allocates.
  void refresh(const BlockMatrix& a);
  /// x := (L L^T)^-1 x, axis by axis; `work` has the size of x.
  void solve(PaddedNodes* x, PaddedNodes* work) const;

 private:
  void analyse(const BlockMatrix& a);
  void factorise();

  std::vector<int> pattern_rows_, pattern_columns_;
  std::vector<int> position_;      // of node i in the elimination order
  AxisValues row_sum_, factored_;  // of the matrix at hand and of the present factor, by node
  // Laplacian in elimination order: its diagonal, and the strictly lower part by rows.
  std::vector<float> degree_;
  std::vector<int> weight_start_, weight_column_, weight_of_slot_;
  std::vector<float> weight_;
  // Strictly lower part of L by columns with 1 / L_jj, and the columns of each row.
  std::vector<int> column_start_, column_fill_, row_start_, row_column_;
  std::vector<int> entry_row_;
  std::vector<float> entry_value_;  // three an entry, one an axis, and one more: read four at a time, the last ignored
  std::vector<Eigen::Array4f> inverse_diagonal_, work_row_;
};

}  // namespace deformable_sim
