// Springs of a sheet on a grid line by line: every line of one direction is a tridiagonal system in the tensions of its
// springs, a register of neighbouring lines solved at a time. Built once for each SIMD instruction set, see
// sheet_kernels.h.
#pragma once

#include "deformable_sim/core/grid/sheet_kernels.h"

namespace deformable_sim {

/// Lines side by side, one a lane. Node k of the line in lane j of a register that starts at `at` lies at
/// at + j + k * step; its spring to node k + 1 has the stiffness along[k * along_step] * across[j + k * across_step]
/// (N/m), 0 where there is none.
template <class Real>
struct GridLines {
  std::ptrdiff_t step;
  const Real* along;
  std::ptrdiff_t along_step;
  const Real* across;  // of lane 0 at k = 0
  std::ptrdiff_t across_step;
  Real length;                 // m, of each spring
  Real* tension;               // N, by the place of a spring's first node; null: none yet, and not wanted
  const unsigned char* keeps;  // by k * along_step, of nodes: pull is wanted
};

/// Positions that answer to forces by x += weight f, and what tells the rate of a spring.
template <class Real>
struct LineMotion {
  Xyz<Real> x;
  const Real* weight;  // m/N by node, 0 at held ones and beyond the sheet
  Xyz<Real> base;      // of the velocities v = (x - base) / tau; null pointers without damping
  Real damping;        // damping time over tau
  Xyz<Real> pull;      // N, += forces of springs, where GridLines::keeps says so
  Real* space;         // kNumbers registers a spring of a line
  static constexpr int kNumbers = 5;
};

/// One step of a Chebyshev iteration for (1 / weight + factor K) z = r in rows, K the bending of the shape:
///   step' = keep step + gain (wr - z - factor weight K z),   z' = z + step',   wr = weight r
template <class Real>
struct BendingStep {
  Xyz<Real> z, wr, step, next;  // next: z'
  const Real* weight;
  Real factor, keep, gain;
};

template <class Real>
struct LineKernels {
  int width;  // numbers a register
  /// Solves lines in registers starting at `at`, springs first <= k < last, from the tensions at hand (fresh: none)
  ///   (1 / (k (1 + damping)) + G W G^T) dt = (k (|d| - L) + c n.w - t) / (k (1 + damping)),   x -= W G^T dt
  /// G the directions of the springs. The same lines again with new directions are another step of Newton's method.
  void (*solve)(const GridLines<Real>&, const LineMotion<Real>&, std::ptrdiff_t at, int first, int last, bool fresh);
  /// to(col, row) = from(row, col), in whole squares of `width`; both have room for them.
  void (*transpose)(const Real* from, std::ptrdiff_t from_stride, int rows, int cols, Real* to,
                    std::ptrdiff_t to_stride);
  /// y = x + lag (x - base).
  void (*extrapolate)(const SheetShape<Real>&, Xyz<Real> x, Xyz<Real> base, Real lag, Xyz<Real> y);
  /// wr = -weight K y, z = step = gain wr
  void (*bending_begin)(const SheetShape<Real>&, Xyz<Real> y, Real gain, const BendingStep<Real>&);
  void (*bending_step)(const SheetShape<Real>&, const BendingStep<Real>&);
  /// x += factor z
  void (*add)(const SheetShape<Real>&, Xyz<Real> z, Real factor, Xyz<Real> x);
  /// v = per_tau (x - base)
  void (*rate)(const SheetShape<Real>&, Xyz<Real> x, Xyz<Real> base, Real per_tau, Xyz<Real> v);
};

const LineKernels<float>& line_kernels(SimdLevel level, float);
const LineKernels<double>& line_kernels(SimdLevel level, double);

}  // namespace deformable_sim
