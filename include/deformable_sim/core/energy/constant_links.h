// A force that is linear in the positions, the same along all axes and for ever.
#pragma once

#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// f_i = sum_j k_ij (y_j - y_i), y = x + damping v: compressed rows, without the diagonal, by node; k_ij = k_ji.
struct ConstantLinks {
  int first_node = 0;  // of row 0
  std::vector<int> row_start{0}, column;
  std::vector<double> stiffness;  // k_ij, N/m; the entry (i, j) of the force's derivative
  std::vector<double> sum;        // over the row
  double damping = 0.0;           // s

  int rows() const { return static_cast<int>(sum.size()); }
};

}  // namespace deformable_sim
