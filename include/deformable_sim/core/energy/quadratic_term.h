// What solvers with a constant matrix want to know of a term whose energy is quadratic in the positions.
#pragma once

#include <vector>

#include <Eigen/SparseCore>

namespace deformable_sim {

/// A term that is f = -K x - D v, K and D constant and the same for x, y and z.
class QuadraticTerm {
 public:
  virtual ~QuadraticTerm() = default;
  /// Entries of K (N/m) and D (N s/m), world nodes, both triangles; entries at one place add up.
  virtual void add_entries(std::vector<Eigen::Triplet<double>>* stiffness,
                           std::vector<Eigen::Triplet<double>>* damping) const = 0;
};

}  // namespace deformable_sim
