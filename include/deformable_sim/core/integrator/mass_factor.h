// Cholesky factor of a consistent mass matrix: what explicit schemes need to turn forces into accelerations.
#pragma once

#include <vector>

#include <Eigen/SparseCholesky>

#include "deformable_sim/core/grasp/kinematics.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// M = P^T L L^T P of the scalar n x n mass matrix without the rows and columns of held nodes, made once for each set
/// of them. Applied to the three axes at once, without allocation.
class MassFactor {
 public:
  /// Factorises when the matrix or the held nodes are others than before.
  void prepare(const Eigen::SparseMatrix<double>& mass, const std::vector<int>& held);
  /// f := M^-1 f, columns are nodes; zero at held nodes.
  void solve(Nodes* f);
  /// q := L^-1 P q and q := P^T L^-T q: with K between them the symmetric operator of the eigenvalues of M^-1 K.
  void solve_lower(Nodes* q);
  void solve_upper(Nodes* q);

 private:
  void release(Nodes* f) const;

  const Eigen::SparseMatrix<double>* mass_ = nullptr;
  std::vector<int> held_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  Eigen::MatrixX3d work_;
};

/// f -= M a of the prescribed nodes, which change from their velocities v to that of this step of dt seconds: what the
/// mass matrix makes their neighbours feel of it. x, v 3 x n at the start of the step.
void add_prescribed_inertia(double dt, const Eigen::SparseMatrix<double>& mass, const Kinematics& kinematics,
                            const Nodes& x, const Nodes& v, Nodes* f);

}  // namespace deformable_sim
