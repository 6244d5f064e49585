#include "deformable_sim/core/grid/sheet_multigrid.h"

#include <algorithm>

namespace deformable_sim {
namespace {

constexpr int kCoarsest = 49;    // nodes at most
constexpr int kNarrowest = 3;    // rows or columns that are not halved any more
constexpr float kJacobi = 0.8f;  // weight of a sweep
constexpr int kMargin = SheetShape<float>::kMargin;

/// Nodes of a coarser line. An even number of nodes is one cell short of the last coarse node, which lies outside.
int halved(int count) {
  return count / 2 + 1;
}

/// Which coarse nodes of a line a fine one is interpolated from.
struct Parents {
  int node[2];
  double weight[2];
  int count;
};
Parents parents(int k, bool halves) {
  if (!halves) return {{k, 0}, {1.0, 0.0}, 1};
  if (k % 2 == 0) return {{k / 2, 0}, {1.0, 0.0}, 1};
  return {{k / 2, k / 2 + 1}, {0.5, 0.5}, 2};
}

constexpr std::array<std::array<int, 2>, 5> kNeighbours{{{0, 0}, {0, 1}, {1, -1}, {1, 0}, {1, 1}}};  // rows, columns

int entry_of(int row_offset, int col_offset) {
  return row_offset == 0 ? col_offset : 3 + col_offset;
}

}  // namespace

void SheetMultigrid::Stencil::resize(int row_count, int col_count) {
  rows = row_count;
  cols = col_count;
  for (auto& e : entry) e.assign(static_cast<size_t>(rows * cols), 0.0);
}

SheetMultigrid::SheetMultigrid(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
                               const Workers* workers)
    : kernels_(stage_kernels(simd_level())),
      rows_(sheet.rows),
      cols_(sheet.cols),
      bands_(Bands::of(rows_, cols_)),
      workers_(bands_.count() > 1 ? workers : nullptr) {
  stride_ = kMargin + (cols_ + kMargin - 1) / kMargin * kMargin;
  fine_free_ = RowArray<float>(rows_, stride_);
  row_ = XyzArray<float>(workers_ != nullptr ? bands_.count() : 1, 2 * stride_);
  for (int k = 0; k < rows_ * cols_; ++k) {
    fine_free_.data()[k / cols_ * stride_ + k % cols_] = free[static_cast<size_t>(k)] != 0 ? 1.0f : 0.0f;
  }
  Stencil masses;
  masses.resize(rows_, cols_);
  masses.entry[Stencil::kHere] = mass;
  coarsen(masses, laplacian_of(sheet), free);
  for (Level& level : levels_) grids_.push_back(level.grid());
  if (levels_.empty()) return;
  const Level& last = levels_.back();
  size_ = last.rows * last.cols;
  padded_ = (size_ + kMargin - 1) / kMargin * kMargin;
  for (auto& inverse : inverse_) inverse.assign(static_cast<size_t>(size_ * padded_ + kMargin), 0.0f);
  dense_r_.assign(static_cast<size_t>(padded_), 0.0f);
  dense_z_ = dense_r_;
  matrix_.resize(size_, size_);
  dense_inverse_.resize(size_, size_);
}

SheetMultigrid::Stencil SheetMultigrid::laplacian_of(const GridSheet& sheet) {
  Stencil stencil;
  stencil.resize(sheet.rows, sheet.cols);
  const auto add = [&](int a, int entry, int b, double k) {
    stencil.entry[Stencil::kHere][static_cast<size_t>(a)] += k;
    stencil.entry[Stencil::kHere][static_cast<size_t>(b)] += k;
    stencil.entry[static_cast<size_t>(entry)][static_cast<size_t>(a)] -= k;
  };
  // A spring over two cells counts as two over one: 4 k for the same strain, shared by the two.
  const auto line = [](const GridSprings& one, const GridSprings& two, int along, int across) {
    double k = one.empty() ? 0.0 : one.along[static_cast<size_t>(along)] * one.across[static_cast<size_t>(across)];
    for (int first : {along - 1, along}) {
      if (two.empty() || first < 0 || first >= static_cast<int>(two.along.size())) continue;
      k += 2.0 * two.along[static_cast<size_t>(first)] * two.across[static_cast<size_t>(across)];
    }
    return k;
  };
  for (int row = 0; row < sheet.rows; ++row) {
    for (int col = 0; col < sheet.cols; ++col) {
      const int a = row * sheet.cols + col;
      const bool right = col + 1 < sheet.cols, down = row + 1 < sheet.rows;
      if (right) add(a, Stencil::kEast, a + 1, line(sheet.warp, sheet.warp_bend, col, row));
      if (down) add(a, Stencil::kSouth, a + sheet.cols, line(sheet.weft, sheet.weft_bend, row, col));
      if (right && down) add(a, Stencil::kSouthEast, a + sheet.cols + 1, sheet.shear);
      if (col > 0 && down) add(a, Stencil::kSouthWest, a + sheet.cols - 1, sheet.shear);
    }
  }
  return stencil;
}

/// Makes the level below, and those below that.
void SheetMultigrid::coarsen(const Stencil& mass, const Stencil& laplacian, const std::vector<char>& free) {
  Level level;
  level.halves_rows = mass.rows > kNarrowest;
  level.halves_cols = mass.cols > kNarrowest;
  level.rows = level.halves_rows ? halved(mass.rows) : mass.rows;
  level.cols = level.halves_cols ? halved(mass.cols) : mass.cols;
  level.stride = kMargin + (level.cols + kMargin - 1) / kMargin * kMargin;
  project(mass, free, level, &level.mass);
  project(laplacian, free, level, &level.laplacian);
  for (auto& entry : level.entry) entry = RowArray<float>(level.rows, level.stride);
  level.free = RowArray<float>(level.rows, level.stride);
  std::vector<char> here(static_cast<size_t>(level.rows * level.cols), 0);
  for (size_t k = 0; k < here.size(); ++k) {
    here[k] = level.mass.entry[Stencil::kHere][k] > 0.0 ? 1 : 0;
    const int node = static_cast<int>(k);
    level.free.data()[node / level.cols * level.stride + node % level.cols] = here[k] != 0 ? 1.0f : 0.0f;
  }
  for (auto* rows : {&level.diagonal, &level.relaxation, &level.extra, &level.r, &level.z, &level.y}) {
    *rows = XyzArray<float>(level.rows, level.stride);
  }
  levels_.push_back(std::move(level));
  const size_t made = levels_.size() - 1;
  if (levels_[made].rows * levels_[made].cols <= kCoarsest) return;
  if (!levels_[made].halves_rows && !levels_[made].halves_cols) return;
  const Stencil coarse_mass = levels_[made].mass, coarse_laplacian = levels_[made].laplacian;
  coarsen(coarse_mass, coarse_laplacian, here);
}

/// coarse = P^T fine P over the free nodes.
void SheetMultigrid::project(const Stencil& fine, const std::vector<char>& free, const Level& level, Stencil* coarse) {
  coarse->resize(level.rows, level.cols);
  const auto add = [&](const Parents& r, const Parents& c, const Parents& r2, const Parents& c2, double value) {
    for (int a = 0; a < r.count; ++a) {
      for (int b = 0; b < c.count; ++b) {
        for (int a2 = 0; a2 < r2.count; ++a2) {
          for (int b2 = 0; b2 < c2.count; ++b2) {
            const int down = r2.node[a2] - r.node[a], right = c2.node[b2] - c.node[b];
            if (down < 0 || (down == 0 && right < 0)) continue;
            coarse->entry[static_cast<size_t>(entry_of(down, right))]
                         [static_cast<size_t>(r.node[a] * coarse->cols + c.node[b])] +=
                value * r.weight[a] * c.weight[b] * r2.weight[a2] * c2.weight[b2];
          }
        }
      }
    }
  };
  for (int row = 0; row < fine.rows; ++row) {
    const Parents r = parents(row, level.halves_rows);
    for (int col = 0; col < fine.cols; ++col) {
      const int node = row * fine.cols + col;
      if (free[static_cast<size_t>(node)] == 0) continue;
      const Parents c = parents(col, level.halves_cols);
      for (size_t e = 0; e < kNeighbours.size(); ++e) {
        const double value = fine.entry[e][static_cast<size_t>(node)];
        const int other = node + kNeighbours[e][0] * fine.cols + kNeighbours[e][1];
        if (value == 0.0 || free[static_cast<size_t>(other)] == 0) continue;
        const Parents r2 = parents(row + kNeighbours[e][0], level.halves_rows);
        const Parents c2 = parents(col + kNeighbours[e][1], level.halves_cols);
        add(r, c, r2, c2, value);
        if (e > 0) add(r2, c2, r, c, value);
      }
    }
  }
}

CoarseGrid SheetMultigrid::Level::grid() {
  return {rows,
          cols,
          stride,
          halves_rows,
          halves_cols,
          entry[Stencil::kEast].data(),
          entry[Stencil::kSouth].data(),
          entry[Stencil::kSouthEast].data(),
          entry[Stencil::kSouthWest].data(),
          diagonal.data(),
          relaxation.data(),
          free.data()};
}

void SheetMultigrid::tune(double inertia, double stiffness) {
  if (inertia == inertia_ && stiffness == stiffness_) return;
  inertia_ = inertia;
  stiffness_ = stiffness;
  for (Level& level : levels_) {
    for (size_t e = 0; e < level.entry.size(); ++e) {
      float* to = level.entry[e].data();
      const auto &mass = level.mass.entry[e], &laplacian = level.laplacian.entry[e];
      for (int row = 0, k = 0; row < level.rows; ++row) {
        for (int col = 0; col < level.cols; ++col, ++k) {
          const auto i = static_cast<size_t>(k);
          to[row * level.stride + col] = static_cast<float>(inertia * mass[i] + stiffness * laplacian[i]);
        }
      }
    }
  }
  refresh();
}

void SheetMultigrid::set_extra(Xyz<float> extra) {
  if (extra.x == nullptr && !has_extra_) return;
  has_extra_ = extra.x != nullptr;
  for (size_t k = 0; k < levels_.size() && has_extra_; ++k) {
    restrict_to_level(k, k == 0 ? extra : levels_[k - 1].extra.data(), levels_[k].extra.data());
  }
  refresh();
}

/// Diagonals, and the factor of the coarsest operator.
void SheetMultigrid::refresh() {
  for (Level& level : levels_) {
    const float* here = level.entry[Stencil::kHere].data();
    const float* free = level.free.data();
    const Xyz<float> extra = level.extra.data(), diagonal = level.diagonal.data(), relaxation = level.relaxation.data();
    const float* const more[3] = {extra.x, extra.y, extra.z};
    float* const whole[3] = {diagonal.x, diagonal.y, diagonal.z};
    float* const relax[3] = {relaxation.x, relaxation.y, relaxation.z};
    for (int d = 0; d < 3; ++d) {
      for (int row = 0; row < level.rows; ++row) {
        for (std::ptrdiff_t at = row * level.stride; at < row * level.stride + level.cols; ++at) {
          const float sum = here[at] + (has_extra_ ? more[d][at] : 0.0f);
          whole[d][at] = free[at] != 0.0f ? sum : 1.0f;
          relax[d][at] = free[at] != 0.0f ? kJacobi / sum : 0.0f;
        }
      }
    }
  }
  if (!levels_.empty()) factorise();
}

void SheetMultigrid::factorise() {
  Level& level = levels_.back();
  const Xyz<float> diagonal = level.diagonal.data();
  const float* const diagonals[3] = {diagonal.x, diagonal.y, diagonal.z};
  for (int d = 0; d < (has_extra_ ? 3 : 1); ++d) {
    matrix_.setZero();
    for (int k = 0; k < size_; ++k) {
      const int row = k / level.cols, col = k % level.cols;
      const std::ptrdiff_t at = row * level.stride + col;
      matrix_(k, k) = static_cast<double>(diagonals[d][at]);
      for (size_t e = 1; e < kNeighbours.size(); ++e) {
        const int other_row = row + kNeighbours[e][0], other_col = col + kNeighbours[e][1];
        if (other_row >= level.rows || other_col < 0 || other_col >= level.cols) continue;
        const int other = other_row * level.cols + other_col;
        matrix_(other, k) = matrix_(k, other) = static_cast<double>(level.entry[e].data()[at]);
      }
    }
    factor_.compute(matrix_);
    dense_inverse_.setIdentity();
    factor_.solveInPlace(dense_inverse_);
    for (int row = 0; row < size_; ++row) {
      for (int col = 0; col < size_; ++col) {
        inverse_[static_cast<size_t>(d)][static_cast<size_t>(row * padded_ + col)] =
            static_cast<float>(dense_inverse_(row, col));
      }
    }
  }
}

void SheetMultigrid::solve_coarsest(Level* level) {
  const Xyz<float> r = level->r.data(), z = level->z.data();
  const float* const from[3] = {r.x, r.y, r.z};
  float* const to[3] = {z.x, z.y, z.z};
  for (size_t d = 0; d < 3; ++d) {
    for (int row = 0; row < level->rows; ++row) {
      std::copy_n(from[d] + row * level->stride, level->cols, dense_r_.begin() + row * level->cols);
    }
    kernels_.coarsest(size_, padded_, inverse_[has_extra_ ? d : 0].data(), dense_r_.data(), dense_z_.data());
    for (int row = 0; row < level->rows; ++row) {
      std::copy_n(dense_z_.begin() + row * level->cols, level->cols, to[d] + row * level->stride);
    }
  }
}

BandLoop SheetMultigrid::bands_of(size_t level) const {
  const CoarseGrid& grid = grids_[level];
  return {Bands::of(grid.rows, grid.cols), workers_};
}

/// The finest grid's share of the work is the larger one: as many bands as it has.
void SheetMultigrid::restrict_to_level(size_t level, Xyz<float> fine, Xyz<float> coarse) {
  const CoarseGrid& grid = grids_[level];
  const Bands bands{grid.rows, level == 0 ? std::min(bands_.count(), grid.rows) : 1};
  const std::ptrdiff_t stride = level == 0 ? stride_ : levels_[level - 1].stride;
  const Xyz<float> row = row_.data();
  BandLoop(bands, workers_).run([&](const RowBand& rows, int scratch) {
    const std::ptrdiff_t at = scratch * 2 * stride_;
    kernels_.restrict_to(grid, stride, free_above(level), fine, coarse, {row.x + at, row.y + at, row.z + at}, rows);
  });
}

void SheetMultigrid::prolong_from_level(size_t level, Xyz<float> fine) {
  const Xyz<float> coarse = levels_[level].z.data();
  const int cols = level == 0 ? cols_ : levels_[level - 1].cols;
  const std::ptrdiff_t stride = level == 0 ? stride_ : levels_[level - 1].stride;
  const BandLoop bands = level == 0 ? BandLoop(bands_, workers_) : bands_of(level - 1);
  bands.run([&](const RowBand& rows, int) {
    kernels_.prolong(grids_[level], cols, stride, free_above(level), coarse, fine, rows);
  });
}

void SheetMultigrid::correct(Xyz<float> r, Xyz<float> z) {
  const size_t last = levels_.size() - 1;
  for (size_t k = 0; k <= last; ++k) {
    Level& level = levels_[k];
    restrict_to_level(k, k == 0 ? r : levels_[k - 1].y.data(), level.r.data());
    if (k == last) break;
    const BandLoop bands = bands_of(k);
    bands.run([&](const RowBand& rows, int) {
      kernels_.coarse_relax_first(grids_[k], level.r.data(), level.z.data(), rows);
    });
    bands.run([&](const RowBand& rows, int) {
      kernels_.coarse_residue(grids_[k], level.z.data(), level.r.data(), level.y.data(), rows);
    });
  }
  solve_coarsest(&levels_[last]);
  for (size_t k = last; k > 0; --k) {
    Level& finer = levels_[k - 1];
    prolong_from_level(k, finer.z.data());
    bands_of(k - 1).run([&](const RowBand& rows, int) {
      kernels_.coarse_relax(grids_[k - 1], finer.z.data(), finer.r.data(), finer.y.data(), rows);
    });
    std::swap(finer.z, finer.y);
  }
  prolong_from_level(0, z);
}

}  // namespace deformable_sim
