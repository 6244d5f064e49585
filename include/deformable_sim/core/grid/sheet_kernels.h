// The loops over the rows of a sheet on a grid, built once for each SIMD instruction set. Plain pointers only: the
// files that are compiled for wider registers must share no inline function with the rest of the program.
#pragma once

#include <cstddef>

#include "deformable_sim/core/simd_level.h"

namespace deformable_sim {

/// Positions lie in rows of `stride` numbers, x, y and z apart; node (row, col) at row * stride + col. Two rows above
/// and below and kMargin numbers left of each row exist and are finite. Every coefficient array has room for kMargin
/// numbers on its left and for whole registers on its right; coefficients of springs that do not exist are zero.
template <class Real>
struct SheetShape {
  static constexpr int kMargin = 16;

  int rows, cols;
  std::ptrdiff_t stride;
  Real damping_time;  // s

  // k = along[col] * across[row] (N/m) of the spring to the right, and the same with rows and columns changed.
  Real warp_length, weft_length, shear_length, warp_bend_length, weft_bend_length;  // m
  const Real *warp_along, *warp_across, *weft_along, *weft_across;
  const Real* shear;       // by column, of both diagonals of the cell to the right
  const Real* shear_rows;  // by row: 1, or 0 in the last row
  bool has_flexion;        // springs over two cells
  const Real *warp_bend_along, *warp_bend_across, *weft_bend_along, *weft_bend_across;

  // f = -sum coefficient * (x + bending_damping v) over the 13 nodes of kStencil, grid_sheet.h.
  bool has_bending;
  Real bending_damping;        // s
  const Real* const* bending;  // by row: an array of `stride` numbers for each of the 13
};

/// Rows first ... end - 1 of a grid: what one call of a loop works on.
struct RowBand {
  int first, end;
  /// The rows before were done just now with the same scratch, which holds what they pass on.
  bool goes_on;
  /// No other band is being worked on: rows ahead may be written.
  bool alone;
};

/// Three arrays, one a coordinate, each pointing at node (0, 0).
template <class Real>
struct Xyz {
  Real *x, *y, *z;
};

/// Space for a row of forces.
template <class Real>
struct SheetScratch {
  static constexpr int kPassed = 9;
  Real* passed;  // kPassed * stride numbers: forces of one row on the next
};

struct SheetKernels {
  /// force: N of all nodes, laid out as x; y = x + bending_damping v, what bends.
  void (*forces)(const SheetShape<double>&, Xyz<double> x, Xyz<double> v, Xyz<double> y, Xyz<double> force,
                 const SheetScratch<double>&);
};

const SheetKernels& sheet_kernels(SimdLevel level);

}  // namespace deformable_sim
