// A force that is linear in the positions, the same along all axes and for ever.
#pragma once

#include <vector>

namespace deformable_sim {

/// f_i = sum_j k_ij (y_j - y_i), y = x + damping v: compressed rows, without the diagonal; k_ij = k_ji. Rows come in an
/// order that suits loops over them, each filled up with zeros to a multiple of four entries.
struct ConstantLinks {
  int first_node = 0;
  std::vector<int> node;  // of a row, less first_node
  std::vector<int> row_start{0};
  std::vector<unsigned> place;    // 4 j: where node j (less first_node) lies among nodes of four numbers
  std::vector<double> stiffness;  // k_ij, N/m; the entry (i, j) of the force's derivative
  std::vector<double> sum;        // over the row
  double damping = 0.0;           // s

  int rows() const { return static_cast<int>(sum.size()); }
};

}  // namespace deformable_sim
