// The loops of an implicit stage over the rows of a sheet: forces and residual in double precision, the linear system
// in single. Plain pointers only, see sheet_kernels.h.
#pragma once

#include "deformable_sim/core/grid/sheet_kernels.h"

namespace deformable_sim {

/// Forces and residual r = inertia x - target - f(x, v) at x, v = per_tau (x - x_base); all laid out as x.
struct SheetResidual {
  Xyz<double> x, x_base;
  const double* per_tau;  // 1/s
  const double* inertia;  // kg/s^2: m (1 / tau^2 + rate / tau)
  Xyz<double> target;     // N
  Xyz<double> v, y;       // written where there is damping: v, and x + bending_damping v
  Xyz<double> force;      // N, written: of springs and bending
  Xyz<float> downhill;    // N, written: -r
  Xyz<float> step;        // m, of which the work is asked; null pointers: none
  const float* weight;    // 1/kg, 0 at held nodes
};
/// A stage as it starts, from columns of points (x y z x y z ...) of the sheet's nodes:
///   x = x0 + reach v0,   target = mass (of_x x_base + of_v v_base + weight) + more
struct SheetStart {
  const double *x0, *v0, *x_base, *v_base, *more;  // more: null = none
  double reach, of_x, of_v;                        // s, 1/s^2, 1/s
  double weight[3];                                // m/s^2
  const double* mass;                              // kg by node, laid out as x
  Xyz<double> x, base, target;
};
/// A stage as it ends: x, v = per_tau (x - base) and force + mass (weight - rate v) as columns of points.
struct SheetEnd {
  Xyz<double> x, base, force;
  const double *per_tau, *mass;
  double rate, weight[3];
  double *points, *velocities, *forces;  // forces: null = not asked
};
struct SheetResidualSums {
  double squares;  // sum |weight r|^2, m^2/s^4
  double work;     // sum step . -r, J
};

/// A = inertia + bending K + springs, of each spring q q^T + t: a symmetric matrix, applied without being assembled.
///
/// What belongs to the nodes of one register lies together, so that one pointer finds it: number k of the nodes from
/// `at` on at numbers * at + k * width, `at` a multiple of the width.
struct SheetMatrix {
  static constexpr int kNumbers = 4;                    // of a spring: q, (N/m)^(1/2), and t, N/m
  static constexpr int kSprings = 4, kLongSprings = 2;  // of a node
  static constexpr int kBending = 13;
  float* springs;               // to the right, down, down to the right, down to the left
  float* long_springs;          // over two cells, to the right and down; null: none
  const float* const* bending;  // by row: coefficients over kStencil, columns in the place of nodes; null: none
  float* passed;                // space for one row of forces on the next: of the springs down
  float damping;                // springs: their damping_time / tau
  float bending_factor;         // 1 + bending_damping / tau
  float transverse;             // 1, or 0: springs without their transverse part
  const float* inertia;         // kg/s^2 by node
  const float* free;            // 1 by node, 0 at held nodes and where there is none
  float* inverse[6];            // of the diagonal blocks, m/N: xx, xy, xz, yy, yz, zz; 0 where `free` is
};

struct StageKernels {
  int width;  // numbers a register, single precision
  void (*start)(const SheetShape<double>&, const SheetStart&, const RowBand&);
  void (*end)(const SheetShape<double>&, const SheetEnd&, const RowBand&);
  /// x, v and y = x + bending_damping v from columns of points.
  void (*load)(const SheetShape<double>&, const double* points, const double* velocities, Xyz<double> x, Xyz<double> v,
               Xyz<double> y);
  /// v and y of SheetResidual; to be called for all bands before residual() where these are not alone.
  void (*rates)(const SheetShape<double>&, const SheetResidual&, const RowBand&);
  SheetResidualSums (*residual)(const SheetShape<double>&, const SheetResidual&, const SheetScratch<double>&,
                                const RowBand&);
  /// to = from + fraction step.
  void (*advance)(const SheetShape<double>&, Xyz<double> from, double fraction, Xyz<float> step, Xyz<double> to,
                  const RowBand&);
  void (*narrow)(const SheetShape<double>&, Xyz<double> from, Xyz<float> to, const RowBand&);

  /// Springs and inverse diagonal blocks of the matrix at x: of a band alone both, of others springs only.
  void (*linearise)(const SheetShape<float>&, Xyz<float> x, const SheetMatrix&, const RowBand&);
  /// The blocks, once the springs of all bands are there.
  void (*find_blocks)(const SheetShape<float>&, const SheetMatrix&, const RowBand&);
  /// p = z + beta p.
  void (*turn)(const SheetShape<float>&, Xyz<float> z, float beta, Xyz<float> p, const RowBand&);
  /// y = A p, before that turn() of a band alone; returns p . y.
  double (*multiply)(const SheetShape<float>&, const SheetMatrix&, Xyz<float> z, float beta, Xyz<float> p, Xyz<float> y,
                     const RowBand&);
  /// z = omega D^-1 r.
  void (*relax_first)(const SheetShape<float>&, const SheetMatrix&, float omega, Xyz<float> r, Xyz<float> z,
                      const RowBand&);
  /// y = r - A z, before that relax_first() of a band in turn.
  void (*relax_residue)(const SheetShape<float>&, const SheetMatrix&, float omega, Xyz<float> r, Xyz<float> z,
                        Xyz<float> y, const RowBand&);
  /// y = r - A z.
  void (*residue)(const SheetShape<float>&, const SheetMatrix&, Xyz<float> z, Xyz<float> r, Xyz<float> y,
                  const RowBand&);
  /// y = z + omega D^-1 (r - A z); returns r . y.
  double (*residue_relax)(const SheetShape<float>&, const SheetMatrix&, float omega, Xyz<float> z, Xyz<float> r,
                          Xyz<float> y, const RowBand&);
  /// y = z + omega D^-1 y; returns r . y.
  double (*relax)(const SheetShape<float>&, const SheetMatrix&, float omega, Xyz<float> z, Xyz<float> r, Xyz<float> y,
                  const RowBand&);
  /// x += alpha p, r -= alpha y; returns sum |weight r|^2.
  double (*descend)(const SheetShape<float>&, float alpha, Xyz<float> p, Xyz<float> y, const float* weight,
                    Xyz<float> x, Xyz<float> r, const RowBand&);
};

const StageKernels& stage_kernels(SimdLevel level);

}  // namespace deformable_sim
