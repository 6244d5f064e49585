// Coarser grids of a sheet: what conjugate gradients know of its smooth motions.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/grid/bands.h"
#include "deformable_sim/core/grid/coarse_kernels.h"
#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/grid/sheet_rows.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// One V-cycle on the grids below the finest. Interpolation P is bilinear, and nothing at held nodes; the operator of
/// each grid is P^T A P of the one above it: springs with their directions and tensions as 3 x 3 blocks, inertia and
/// bending as scalars. One block-Jacobi sweep before and after; a dense inverse on the coarsest grid [Briggs 2000]. Any
/// number of rows and columns.
///
/// Springs at held nodes are kept in P^T A P as if those were free, and resist there as ground does: no grid has to
/// know which of its nodes are held in part. Bending reaches over two cells, its P^T A P over two coarse ones: what
/// does so is lumped.
///
/// Not good at: wrinkles a few cells long, on which bilinear coarse motions would stretch the cloth.
class SheetMultigrid {
 public:
  /// A block of the finest grid's diagonal that is neither spring nor inertia nor bending, N/m: xx xy xz yy yz zz.
  struct Extra {
    int node;  // of the sheet
    std::array<float, CoarseGrid::kBlock> block;
  };

  /// mass: kg, of the sheet's nodes; free: by node, 0 at held ones; workers: null is one thread.
  SheetMultigrid(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
                 const Workers* workers = nullptr);

  /// inertia: 1/s^2, times the masses; bending: a factor on the sheet's own.
  void tune(double inertia, double bending);
  /// The operators of all grids from the springs of the finest.
  void refresh(const SheetShape<float>& shape, const SheetMatrix& matrix, const std::vector<Extra>& extra);
  /// z += P V(P^T r).
  void correct(Xyz<float> r, Xyz<float> z);

 private:
  /// A symmetric matrix of nine entries a node: itself, and the neighbours of higher index.
  struct Stencil {
    enum { kHere, kEast, kSouthWest, kSouth, kSouthEast, kEntries };
    std::array<std::vector<double>, kEntries> entry;
  };
  struct Level {
    int rows, cols;
    bool halves_rows, halves_cols;
    Stencil mass, bending;
    std::ptrdiff_t stride, line;  // line: see CoarseKernels::coarsen_sheet()
    RowArray<float> links, ground, inverse, extra, free, scalar_sum;
    RowArray<float> passed, space;  // a row a band
    std::array<RowArray<float>, CoarseGrid::kLinks> scalar;
    XyzArray<float> r, z, y;
    std::vector<int> patched;  // nodes whose block of `extra` is not zero
    std::vector<char> is_patched;
    CoarseGrid grid();
    float* extra_of(int node, int width);
  };

  void coarsen_finest(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free);
  Level below(int rows, int cols) const;
  int scratch_count() const { return workers_ != nullptr ? Bands::kMost : 1; }
  void add(Level level);
  void find_shore(const std::vector<char>& free);
  void find_ground(const SheetMatrix& matrix, const std::vector<Extra>& extra);
  void hold(const SheetMatrix& matrix);
  void spread(size_t to, int node, int cols, const std::array<float, CoarseGrid::kBlock>& block);
  void factorise();
  void solve_coarsest(Level* level);
  void restrict_to_level(size_t level, Xyz<float> fine, Xyz<float> coarse);
  void prolong_from_level(size_t level, Xyz<float> fine);
  /// Loops over the rows of a level; below the first they are too short for threads.
  BandLoop bands_of(size_t level) const;
  /// The finest grid's share of the work is the larger one: as many bands as it has.
  BandLoop bands_below(size_t level) const;
  CoarseGrid grid_with_scratch(size_t level, int scratch);
  const float* free_above(size_t level) const {
    return level == 0 ? fine_free_.data() : levels_[level - 1].free.data();
  }

  const CoarseKernels& kernels_;
  int rows_, cols_;
  Bands bands_;  // of the finest grid
  const Workers* workers_;
  std::ptrdiff_t stride_;
  RowArray<float> fine_free_;
  XyzArray<float> row_;  // a row a band
  std::vector<Level> levels_;
  std::vector<CoarseGrid> grids_;
  std::vector<int> shore_;  // held nodes next to free ones
  double inertia_ = 0.0, bending_ = 0.0;

  // Coarsest.
  int size_ = 0, padded_ = 0;  // numbers: three a node
  std::vector<double> matrix_;
  std::vector<float> inverse_, dense_r_, dense_z_;
};

}  // namespace deformable_sim
