// Conjugate gradients preconditioned by multigrid on aggregates, for scenes of any mesh.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/linear/block_kernels.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {

/// Solves (A + links) x = b from x = 0 in single precision. One iteration: block-Jacobi sweep, AggregationMultigrid,
/// sweep, each on what the one before has left of A, in whose diagonal blocks the sweeps count the links; the product
/// with A + links. Without a coarse level that works, one sweep alone. Links of less than a hundredth of those around
/// are left out.
///
/// Not good at: more than four digits, and two of what links do (Newton's method, whose residual is exact, gives the
/// others); links that are stiffer than all else, of which only the diagonal preconditions.
class MultigridSolver : public LinearSolver {
 public:
  /// To be called before prepare(): links whose derivatives, times 1 + damping / tau (s), A lacks, and the nodes whose
  /// rows are held. The links must outlive the use of the solver.
  virtual void set_links(const std::vector<const ConstantLinks*>& links, double tau, const std::vector<int>& held) = 0;
  /// To be called before prepare(): springs that A lacks as well.
  virtual void set_springs(const std::vector<SpringElement>& springs) = 0;
  /// Before prepare() and every solve(): where the springs are, x (m, kept until solve()), and what of them A lacks, dx
  /// dF/dd + dv dF/dw as Spring::stiffness has it, projected or axial.
  enum class Transverse { kProjected, kNone };
  virtual void place_springs(const Nodes& x, double dx, double dv, Transverse transverse) = 0;
  /// What is kept when only tau or the terms change is made anew by the next prepare().
  virtual void forget() = 0;
};

std::unique_ptr<MultigridSolver> make_multigrid_solver();

}  // namespace deformable_sim
