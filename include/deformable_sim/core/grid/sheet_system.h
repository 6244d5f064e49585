// The linear system of an implicit stage of one sheet, never assembled, and its solution in single precision.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/grid/bands.h"
#include "deformable_sim/core/grid/sheet_multigrid.h"
#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {

/// What ties a few nodes to a plane, to a target or to each other: A += W^T H W, W p = sum weight p[place].
struct SheetCoupling {
  std::array<std::ptrdiff_t, 4> place;  // in the rows
  std::array<double, 4> weight;
  int count;
  Mat3 matrix;  // H, N/m, symmetric and positive semi-definite
};

/// A = inertia + springs (projected) + bending + couplings; A p = r by conjugate gradients, preconditioned by a
/// block-Jacobi sweep, one V-cycle on the coarser grids and a second sweep, each on what the one before has left.
///
/// Not good at: more than four digits (single precision; Newton's method, whose residual is of double precision, gives
/// them); couplings between nodes, of which the coarser grids see only what resists a common motion.
class SheetSystem {
 public:
  /// mass: kg, of the sheet's nodes; free: by node, 0 at held ones; workers: null is one thread. The sheet may go.
  SheetSystem(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
              const Workers* workers = nullptr);

  const SheetRows<float>& rows() const { return rows_; }
  /// kg/s^2 by node, laid out as rows; to be filled before linearise() and kept until the next change.
  float* inertia() { return inertia_.data(); }
  /// 1/kg by node, 0 at held nodes.
  const float* weight() const { return weight_.data(); }
  /// To be filled before linearise().
  std::vector<SheetCoupling>& couplings() { return couplings_; }

  /// tau in s; mass_rate: 1/s^2, inertia() over mass where it is the same everywhere.
  void set_step(double tau, double mass_rate, Jacobian kind);
  /// The matrix at x.
  void linearise(Xyz<double> x, const SheetShape<double>& shape);

  /// -r, N; to be written before solve(), which leaves what remains.
  Xyz<float> residual() { return r_.data(); }
  /// The solution, m.
  Xyz<float> step() { return step_.data(); }
  /// `absolute` and `relative` are of the RMS of weight |r| over `free_count` nodes, `start` its value before. Returns
  /// step . residual, J, as it was before.
  double solve(const LinearTolerance& tolerance, double start, double free_count, LinearReport* report);

  /// p = z + beta p, y = A p; returns p . y.
  double multiply(Xyz<float> z, float beta, Xyz<float> p, Xyz<float> y);
  /// Returns r . preconditioned().
  double precondition(Xyz<float> r);
  /// The preconditioner times r, until the next call.
  Xyz<float> preconditioned() { return z_.data(); }

 private:
  void pack_bending(const GridStencil& bending);
  void find_residue(Xyz<float> z, Xyz<float> r, Xyz<float> y);
  const SheetMatrix& matrix(int scratch) const { return matrix_[static_cast<size_t>(scratch)]; }
  void patch_diagonal();
  void add_couplings(Xyz<float> p, float sign, Xyz<float> y, double* work) const;

  BandLoop bands_;
  SheetRows<float> rows_;
  const StageKernels& kernels_;
  SheetMultigrid multigrid_;
  std::vector<SheetMatrix> matrix_;  // the same but for the scratch
  double damping_time_, bending_damping_;
  RowArray<float> springs_, long_springs_;
  std::vector<RowArray<float>> bending_;  // of each kind of row
  std::vector<const float*> bending_rows_;
  std::array<RowArray<float>, 6> inverse_;
  RowArray<float> inertia_, free_, weight_;
  XyzArray<float> x_, r_, z_, p_, y_, step_;
  std::vector<SheetCoupling> couplings_;
  std::vector<SheetMultigrid::Extra> extra_;  // what couplings add to the diagonal, for the coarser grids
  std::vector<Mat3> blocks_;                  // and for the finest, of the same nodes
  std::vector<int> patch_of_;                 // by node: index in extra_, -1: none
};

}  // namespace deformable_sim
