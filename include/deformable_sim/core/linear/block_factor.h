// Cholesky factor of a symmetric positive definite BlockMatrix, in double precision and without allocation once warm.
#pragma once

#include <vector>

#include "deformable_sim/core/linear/block_matrix.h"

namespace deformable_sim {

/// A = L L^T in 3 x 3 blocks, row by row, in a minimum degree order that the pattern alone decides. Blocks that vanish
/// (a slack region of a strain-limited sheet) cost nothing but their test.
///
/// Not good at: large volumes, whose factors fill up; a solution that need not be exact, see ScalarFactor.
class BlockFactor {
 public:
  /// Elimination order and pattern of L. Allocates.
  void analyse(const BlockMatrix& pattern);
  /// False when A is not positive definite to working precision.
  bool factorise(const BlockMatrix& a);
  /// x := A^-1 x, a column per node.
  void solve(Nodes* x);
  /// Blocks of L below its diagonal, at most.
  int fill() const { return static_cast<int>(entry_.size()); }

 private:
  std::vector<int> position_;  // of node i in the elimination order
  // Strictly lower part of A by rows of the elimination order.
  struct Source {
    int column, slot;
  };
  std::vector<int> source_start_, diagonal_slot_;
  std::vector<Source> source_;
  // Strictly lower part of L: by columns, and the columns of each row.
  std::vector<int> column_start_, column_fill_, entry_row_, row_start_, row_column_;
  std::vector<Mat3> entry_, inverse_diagonal_, work_;
  Nodes permuted_;
};

}  // namespace deformable_sim
