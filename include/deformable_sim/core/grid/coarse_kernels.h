// The loops of the coarser grids of a sheet, in single precision. Plain pointers only, see sheet_kernels.h.
#pragma once

#include "deformable_sim/core/grid/stage_kernels.h"

namespace deformable_sim {

/// A coarser grid and its matrix A of symmetric 3 x 3 blocks, between neighbours and diagonal neighbours. Blocks lie as
/// xx xy xz yy yz zz, those of the nodes of one register together, as in SheetMatrix.
struct CoarseGrid {
  static constexpr int kBlock = 6;  // numbers
  static constexpr int kLinks = 4;  // of a node: to the right, down, down to the right, down to the left
  int rows, cols;
  std::ptrdiff_t stride;
  bool halves_rows, halves_cols;  // of the finer grid: node k lies on its node 2k, or k
  const float* free;              // 1 by node, 0 where the finer grid has no free node
  float* links;                   // -A between two nodes; springs alone until add_scalars()
  float* ground;                  // sums of the rows of A
  float* inverse;                 // of the diagonal blocks, m/N; 0 where `free` is
  const float* scalar[kLinks];    // N/m, of what is the same for x, y and z: its part in A between two nodes,
  const float* scalar_sum;        //   and the sums of its rows
  const float* extra;             // blocks, added to the diagonal; null: none
  float* passed;                  // space for a row of forces on the next
};

/// Bands are of the rows that are written.
struct CoarseKernels {
  int width;  // numbers a register
  /// Links of a grid from those of the next finer one, the sheet itself or a grid: P^T K P, P bilinear, K any sum of
  /// springs; of springs over two cells what they are to smooth motions. `space`: kSpace rows of `line` numbers each,
  /// zero but for the first `cols` of the finer grid, and so is a row before them.
  void (*coarsen_sheet)(const SheetShape<float>&, const SheetMatrix&, const CoarseGrid& to, float* space,
                        std::ptrdiff_t line, const RowBand&);
  void (*coarsen)(const CoarseGrid& from, const CoarseGrid& to, float* space, std::ptrdiff_t line, const RowBand&);
  /// Links of springs to links of A. After it, and once for all bands, ground and inverse from links and extra.
  void (*add_scalars)(const CoarseGrid&, const RowBand&);
  void (*find_diagonal)(const CoarseGrid&, const RowBand&);

  // Between grids; `free` and `stride` of the finer one.
  void (*restrict_to)(const CoarseGrid&, std::ptrdiff_t stride, const float* free, Xyz<float> fine, Xyz<float> coarse,
                      Xyz<float> row, const RowBand&);
  void (*prolong)(const CoarseGrid&, int cols, std::ptrdiff_t stride, const float* free, Xyz<float> coarse,
                  Xyz<float> fine, const RowBand&);
  /// z = omega D^-1 r, D the diagonal blocks.
  void (*relax_first)(const CoarseGrid&, float omega, Xyz<float> r, Xyz<float> z, const RowBand&);
  /// y = r - A z.
  void (*residue)(const CoarseGrid&, Xyz<float> z, Xyz<float> r, Xyz<float> y, const RowBand&);
  /// y = z + omega D^-1 (r - A z).
  void (*relax)(const CoarseGrid&, float omega, Xyz<float> z, Xyz<float> r, Xyz<float> y, const RowBand&);
  /// z = inverse r, `size` numbers each, rows of the symmetric matrix `stride` apart.
  void (*coarsest)(int size, int stride, const float* inverse, const float* r, float* z);
  /// matrix := its inverse, `size` rows `stride` apart, a multiple of kMargin. False, and rubbish, where it is not
  /// positive definite.
  bool (*invert)(int size, int stride, double* matrix);

  static constexpr int kSpace = 54;  // rows: see coarsen_sheet()
};

const CoarseKernels& coarse_kernels(SimdLevel level);

}  // namespace deformable_sim
