// Coarser grids of a sheet: what conjugate gradients know of its smooth motions.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Cholesky>

#include "deformable_sim/core/grid/bands.h"
#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/grid/sheet_rows.h"
#include "deformable_sim/core/grid/stage_kernels.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// One V-cycle on the grids below the finest, for the scalar operator
///
///   S = inertia M + stiffness L + extra,   L the graph Laplacian of the springs' stiffnesses,
///
/// the same for x, y and z but for `extra`. Interpolation is bilinear, and nothing at held nodes; operators are P^T S
/// P, `extra` lumped; one damped Jacobi sweep before and after; a dense inverse on the coarsest grid [Briggs 2000]. Any
/// number of rows and columns.
///
/// Not good at: bending stiffness, of which the coarser grids know nothing; anisotropy that the sweeps do not see.
class SheetMultigrid {
 public:
  /// mass: kg, of the sheet's nodes; free: by node, 0 at held ones; workers: null is one thread.
  SheetMultigrid(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
                 const Workers* workers = nullptr);

  /// inertia: 1/s^2; stiffness: a factor on the springs' own.
  void tune(double inertia, double stiffness);
  /// N/m, by fine node, laid out as the fine grid; null pointers: none.
  void set_extra(Xyz<float> extra);
  /// z += P V(P^T r).
  void correct(Xyz<float> r, Xyz<float> z);

 private:
  /// A symmetric matrix of nine entries a node: itself, and the neighbours of higher index.
  struct Stencil {
    enum { kHere, kEast, kSouthWest, kSouth, kSouthEast, kEntries };
    int rows = 0, cols = 0;
    std::array<std::vector<double>, kEntries> entry;
    void resize(int row_count, int col_count);
  };
  struct Level {
    int rows, cols;
    bool halves_rows, halves_cols;
    Stencil mass, laplacian;
    std::ptrdiff_t stride;
    std::array<RowArray<float>, Stencil::kEntries> entry;
    RowArray<float> free;
    XyzArray<float> diagonal, relaxation, extra;
    XyzArray<float> r, z, y;
    CoarseGrid grid();
  };

  static Stencil laplacian_of(const GridSheet& sheet);
  void coarsen(const Stencil& mass, const Stencil& laplacian, const std::vector<char>& free);
  static void project(const Stencil& fine, const std::vector<char>& free, const Level& level, Stencil* coarse);
  void refresh();
  void factorise();
  void solve_coarsest(Level* level);
  void restrict_to_level(size_t level, Xyz<float> fine, Xyz<float> coarse);
  void prolong_from_level(size_t level, Xyz<float> fine);
  /// Loops over the rows of a level; from the second on they are too short for threads.
  BandLoop bands_of(size_t level) const;
  const float* free_above(size_t level) const {
    return level == 0 ? fine_free_.data() : levels_[level - 1].free.data();
  }

  const StageKernels& kernels_;
  int rows_, cols_;
  Bands bands_;  // of the finest grid
  const Workers* workers_;
  std::ptrdiff_t stride_;
  RowArray<float> fine_free_;
  XyzArray<float> row_;  // one a band
  std::vector<Level> levels_;
  std::vector<CoarseGrid> grids_;
  double inertia_ = 0.0, stiffness_ = 0.0;
  bool has_extra_ = false;

  // Coarsest.
  int size_ = 0, padded_ = 0;
  Eigen::MatrixXd matrix_, dense_inverse_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  std::array<std::vector<float>, 3> inverse_;
  std::vector<float> dense_r_, dense_z_;
};

}  // namespace deformable_sim
