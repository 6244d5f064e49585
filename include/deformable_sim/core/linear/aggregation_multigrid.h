// Coarse correction for matrices of any mesh: algebraic multigrid by smoothed aggregation of a scalar operator.
#pragma once

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>

#include "deformable_sim/core/linear/block_kernels.h"
#include "deformable_sim/core/linear/scalar_factor.h"

namespace deformable_sim {

/// n x n, symmetric, by rows.
using GraphMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Groups of nodes that strong links hold together: group by node, -1 for a node without any. A node whose neighbours
/// are all free begins a group with them; what is left joins its strongest link's group [Vanek 1996]. In the order of
/// the nodes, so that the same graph gives the same groups. `links`: off-diagonal entries are link strengths.
std::vector<int> aggregates(const GraphMatrix& links, int* count);

/// Three scalar operators, one an axis, as in ScalarFactor: one graph Laplacian and a diagonal for each axis. Its
/// smooth part is solved by a V-cycle over ever coarser graphs; the finest one is only restricted from and prolonged
/// to, what oscillates there is left to whoever calls. Interpolation is by aggregates, smoothed once on the Laplacian
/// (weight 2/3), so that a constant stays one; coarse Laplacians are P^T L P, coarse diagonals P^T of the finer ones;
/// Jacobi 0.7 before and after; a dense inverse on the coarsest.
///
/// Not good at: constraints along directions between the axes, which it sees as weaker ones along the axes; bending.
class AggregationMultigrid {
 public:
  explicit AggregationMultigrid(const BlockKernels& kernels) : kernels_(kernels) {}

  /// New levels for a graph Laplacian (N/m).
  void prepare(const GraphMatrix& laplacian);
  /// New diagonals: `row_sum`, N/m by node and axis, comes on top of the Laplacian. False, and no correction from then
  /// on, where a level is not positive definite. Never allocates.
  bool refresh(const AxisValues& row_sum);
  /// c := an approximation of (L + row sums)^-1 r; symmetric and positive semi-definite in r.
  void correct(const PaddedNodes& r, PaddedNodes* c);

  bool empty() const { return levels_.empty(); }
  /// Nodes of each coarser level.
  std::vector<int> sizes() const;

 private:
  /// A scalar matrix in single precision.
  struct Rows {
    std::vector<int> start{0};
    std::vector<unsigned> place;  // four times the column
    std::vector<float> value;
    LinkRows<float> rows(const float* diagonal) const;
  };
  struct Level {
    int size = 0;
    Rows restriction;    // from the finer level: a row a node of this one
    Rows interpolation;  // to it: a row a node of that one
    Rows links;          // minus the Laplacian's entries off the diagonal
    std::vector<float> degree;
    AxisValues row_sum, diagonal, relaxation;
    PaddedNodes r, z, y;
  };
  static Rows rows_of(const GraphMatrix& m, double factor);
  bool add_level(const GraphMatrix& laplacian, GraphMatrix* coarse);
  bool factorise();
  void solve_coarsest();

  const BlockKernels& kernels_;
  std::vector<Level> levels_;
  bool works_ = false;
  Eigen::MatrixXd dense_, dense_inverse_;  // of the coarsest level
  Eigen::LDLT<Eigen::MatrixXd> factor_;
  AxisValues inverse_;  // its inverse by columns
};

}  // namespace deformable_sim
