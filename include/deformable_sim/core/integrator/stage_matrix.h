// The linear system of an implicit stage: its matrix, which rows are held, and what a solver keeps from step to step.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/linear/linear_solver.h"
#include "deformable_sim/core/linear/node_couplings.h"

namespace deformable_sim {

class MultigridSolver;

/// A = M / tau^2 - df/dx - (1 / tau) df/dv + contacts, one block row a node, rows and columns of prescribed nodes
/// replaced by the identity.
///
/// Springs and terms of constant links may stay apart: their part of A is then known to a MultigridSolver alone, and
/// blocks() lacks it.
class StageMatrix {
 public:
  enum class Links { kInBlocks, kApart };
  StageMatrix(const SolverSettings& settings, Links links);
  void reset();
  /// Start of a stage. A new pattern, tau (s), set of held nodes or of terms makes the kept parts stale.
  void renew(const Dynamics& d, double tau);

  /// A = M / tau^2. Rows of the nodes `near` belong to another tau; with a mass matrix M_ij / (tau_i tau_j).
  void set_inertia(const std::vector<int>& near, double tau_near);
  /// A -= dx df/dx + dv df/dv at `s`.
  void add_forces(const State& s, double dx, double dv, Jacobian kind);
  /// A = (A + A^T) / 2.
  void make_symmetric();
  void hold();
  /// step = A^-1 b, zero at held nodes; adds to the report's count.
  LinearReport solve(const Nodes& b, const Eigen::VectorXd& weight, const LinearTolerance& tolerance, Nodes* step,
                     StepReport* report);

  /// The same with the matrix of the last solve(); false where the solver keeps no factor.
  bool solve_again(const Nodes& b, Nodes* step);

  BlockMatrix& blocks() { return matrix_; }
  /// Beside blocks(), which have their diagonal; to be filled anew for every matrix.
  NodeCouplings& couplings() { return couplings_; }
  const std::vector<int>& held() const { return held_; }

 private:
  void find_held_slots();
  void find_mass_slots();
  void sort_terms();

  std::unique_ptr<LinearSolver> solver_;
  MultigridSolver* multigrid_ = nullptr;  // the solver, where links stay apart
  std::vector<const ConstantLinks*> links_;
  std::vector<const Energy*> in_blocks_;
  BlockMatrix matrix_;
  NodeCouplings couplings_;
  double tau_ = 0.0;
  const Dynamics* dynamics_ = nullptr;

  // Kept from step to step.
  const BlockMatrix* pattern_ = nullptr;
  const Eigen::SparseMatrix<double>* mass_matrix_ = nullptr;
  std::vector<int> held_, held_slots_;
  std::vector<int> mass_slots_;  // of the mass matrix' entries, in its order
  std::vector<double> share_;    // tau / tau_i of each node; only with a mass matrix
  double prepared_tau_ = 0.0;
  std::vector<const Energy*> prepared_energies_;
  std::vector<const Energy*> sorted_energies_;
  bool stale_ = true;
};

}  // namespace deformable_sim
