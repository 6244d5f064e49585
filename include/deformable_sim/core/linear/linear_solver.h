// Solvers of A x = b for the matrices of implicit steps.
#pragma once

#include <memory>

#include "deformable_sim/core/linear/block_matrix.h"

namespace deformable_sim {

class NodeCouplings;

struct LinearReport {
  int iterations = 0;    // 0 for a direct solver
  bool solved = true;    // tolerance reached; direct: the factorisation exists
  bool definite = true;  // false: A was found not to be positive definite, x is of no use
  bool kept = false;     // solve_again() has factors of all of A
};

/// When an iterative solver may stop: RMS over nodes of |r_i| * weight_i at or below max(absolute, relative * initial).
struct LinearTolerance {
  double relative = 1e-2;
  double absolute = 0.0;
  int iterations = 200;
};

/// A is symmetric positive definite; rows of held nodes are identity.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;
  /// Called when the pattern, the time step, the terms or the set of held nodes have changed: what
  /// is worth keeping over many steps is made here (symbolic analysis, preconditioner).
  virtual void prepare(const BlockMatrix& a) = 0;
  /// Solves A x = b. x holds the initial guess of iterative solvers. `weight` has one entry a node, see
  /// LinearTolerance.
  virtual LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                             const LinearTolerance& tolerance, Nodes* x) = 0;
  /// Adds what is beside the diagonal of `couplings` to the matrices of all solves from now on; null: nothing. False by
  /// solvers that cannot, for which NodeCouplings::solve() does. They must outlive their use.
  virtual bool take(const NodeCouplings* /*couplings*/) { return false; }
  /// x := A^-1 b with the matrix of the last solve(); false, and nothing done, by solvers that keep no factor of all of
  /// it.
  virtual bool solve_again(const Nodes& /*b*/, Nodes* /*x*/) { return false; }
};

/// Sparse Cholesky factorisation (LDL^T, minimum degree order) of the 3n x 3n matrix. Exact and slow: the oracle for
/// tests and statics. Eigen's factorisation allocates.
std::unique_ptr<LinearSolver> make_direct_solver();

/// Conjugate gradients in single precision inside a double precision refinement, preconditioned by a block-Jacobi
/// sweep, one exact solve of a scalar n x n operator an axis (mass, contacts and graph Laplacian; factors kept while
/// they fit) and a second sweep; see doc/theory/integrators.md.
std::unique_ptr<LinearSolver> make_conjugate_gradient_solver();

/// Parts of the matrix that are not coupled to others are told apart. Narrow bands (ropes, rods with their angles,
/// closed loops, strips) are factorised, exactly and in a time that grows with their length alone; all others go to
/// conjugate gradients together. Cost: two sweeps, some 250 multiplications a node of a chain with bending.
std::unique_ptr<LinearSolver> make_banded_solver();

}  // namespace deformable_sim
