#include "deformable_sim/core/grid/sheet_multigrid.h"

#include <algorithm>

#include "coarse_lines.h"

namespace deformable_sim {
namespace {

constexpr float kSweep = 0.65f;  // weight of a block-Jacobi sweep: below 2/3, or the cycle need not be definite
constexpr int kBlock = CoarseGrid::kBlock;

}  // namespace

void SheetMultigrid::tune(double inertia, double bending) {
  if (inertia == inertia_ && bending == bending_) return;
  inertia_ = inertia;
  bending_ = bending;
  // In the order of links.
  constexpr std::array<size_t, CoarseGrid::kLinks> kEntryOf{Stencil::kEast, Stencil::kSouth, Stencil::kSouthEast,
                                                            Stencil::kSouthWest};
  for (Level& level : levels_) {
    level.scalar_sum.clear();
    float* sum = level.scalar_sum.data();
    const auto place = [&](int node) { return node / level.cols * level.stride + node % level.cols; };
    const auto value = [&](size_t e, int node) {
      const auto i = static_cast<size_t>(node);
      return static_cast<float>(inertia * level.mass.entry[e][i] + bending * level.bending.entry[e][i]);
    };
    for (int node = 0; node < level.rows * level.cols; ++node) {
      sum[place(node)] += value(Stencil::kHere, node);
      for (size_t k = 0; k < kEntryOf.size(); ++k) {
        const float s = value(kEntryOf[k], node);
        level.scalar[k].data()[place(node)] = s;
        if (s == 0.0f) continue;
        sum[place(node)] += s;
        sum[place(node + kNeighbours[kEntryOf[k]][0] * level.cols + kNeighbours[kEntryOf[k]][1])] += s;
      }
    }
  }
}

void SheetMultigrid::refresh(const SheetShape<float>& shape, const SheetMatrix& matrix,
                             const std::vector<Extra>& extra) {
  for (size_t k = 0; k < levels_.size(); ++k) {
    bands_below(k).run([&](const RowBand& rows, int scratch) {
      Level& level = levels_[k];
      float* space = level.space.data() + scratch * CoarseKernels::kSpace * level.line;
      if (k == 0) return kernels_.coarsen_sheet(shape, matrix, grids_[0], space, level.line, rows);
      kernels_.coarsen(grids_[k - 1], grids_[k], space, level.line, rows);
    });
  }
  for (size_t k = 0; k < levels_.size(); ++k) {
    bands_of(k).run([&](const RowBand& rows, int) { kernels_.add_scalars(grids_[k], rows); });
  }
  find_ground(matrix, extra);
  for (size_t k = 0; k < levels_.size(); ++k) {
    grids_[k].extra = levels_[k].patched.empty() ? nullptr : levels_[k].extra.data();
    bands_of(k).run([&](const RowBand& rows, int) { kernels_.find_diagonal(grids_[k], rows); });
  }
  factorise();
}

/// Level::extra of all grids.
void SheetMultigrid::find_ground(const SheetMatrix& matrix, const std::vector<Extra>& extra) {
  for (Level& level : levels_) {
    for (int node : level.patched) {
      float* block = level.extra_of(node, kernels_.width);
      for (int k = 0; k < kBlock; ++k) block[k * kernels_.width] = 0.0f;
      level.is_patched[static_cast<size_t>(node)] = 0;
    }
    level.patched.clear();
  }
  hold(matrix);
  for (const Extra& e : extra) spread(0, e.node, cols_, e.block);
  for (size_t k = 1; k < levels_.size(); ++k) {
    Level& above = levels_[k - 1];
    for (int node : above.patched) {
      const float* p = above.extra_of(node, kernels_.width);
      std::array<float, kBlock> block;
      for (size_t e = 0; e < kBlock; ++e) block[e] = p[static_cast<int>(e) * kernels_.width];
      spread(k, node, above.cols, block);
    }
  }
}

/// The springs of held nodes, as ground beneath them.
void SheetMultigrid::hold(const SheetMatrix& matrix) {
  const int width = kernels_.width;
  const auto add = [&](const float* springs, int springs_of_node, int row, int col, int spring,
                       std::array<float, kBlock>* sum) {
    const int lane = (col % width + width) % width;
    const float* p =
        springs + SheetMatrix::kNumbers * (springs_of_node * (row * stride_ + col - lane) + spring * width) + lane;
    const float x = p[0], y = p[width], z = p[2 * width], t = p[3 * width];
    const float block[kBlock] = {x * x + t, x * y, x * z, y * y + t, y * z, z * z + t};
    for (size_t k = 0; k < kBlock; ++k) (*sum)[k] += block[k];
  };
  for (int node : shore_) {
    const int row = node / cols_, col = node % cols_;
    std::array<float, kBlock> sum{};
    const auto one = [&](int r, int c, int spring) { add(matrix.springs, SheetMatrix::kSprings, r, c, spring, &sum); };
    for (int spring = 0; spring < SheetMatrix::kSprings; ++spring) one(row, col, spring);
    one(row, col - 1, 0);
    one(row - 1, col, 1);
    one(row - 1, col - 1, 2);
    one(row - 1, col + 1, 3);
    if (matrix.long_springs != nullptr) {
      const auto two = [&](int r, int c, int spring) {
        add(matrix.long_springs, SheetMatrix::kLongSprings, r, c, spring, &sum);
      };
      for (int spring = 0; spring < SheetMatrix::kLongSprings; ++spring) two(row, col, spring);
      two(row, col - 2, 0);
      two(row - 2, col, 1);
    }
    spread(0, node, cols_, sum);
  }
}

/// From a node of the grid above to the diagonal of a grid: P^T X P, lumped.
void SheetMultigrid::spread(size_t to, int node, int cols, const std::array<float, kBlock>& block) {
  Level& level = levels_[to];
  const Parents r = parents(node / cols, level.halves_rows), c = parents(node % cols, level.halves_cols);
  for (int a = 0; a < r.count; ++a) {
    for (int b = 0; b < c.count; ++b) {
      const int parent = r.node[a] * level.cols + c.node[b];
      char& known = level.is_patched[static_cast<size_t>(parent)];
      if (known == 0) level.patched.push_back(parent);
      known = 1;
      const auto weight = static_cast<float>(r.weight[a] * c.weight[b]);
      float* sum = level.extra_of(parent, kernels_.width);
      for (size_t k = 0; k < kBlock; ++k) sum[static_cast<int>(k) * kernels_.width] += weight * block[k];
    }
  }
}

float* SheetMultigrid::Level::extra_of(int node, int width) {
  const int col = node % cols, lane = col % width;
  return extra.data() + kBlock * (node / cols * stride + col - lane) + lane;
}

/// Of the coarsest operator; links as they are, so that what they say of a common motion is nothing but rounding.
void SheetMultigrid::factorise() {
  Level& level = levels_.back();
  const int width = kernels_.width, nodes = level.rows * level.cols;
  constexpr int kPlace[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};  // in a block
  const auto add = [&](int a, int b, const float* block, double sign) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        matrix_[static_cast<size_t>((3 * a + i) * padded_ + 3 * b + j)] +=
            sign * static_cast<double>(block[kPlace[i][j] * width]);
      }
    }
  };
  const auto is_free = [&](int row, int col) { return level.free.data()[row * level.stride + col] != 0.0f; };
  std::fill(matrix_.begin(), matrix_.end(), 0.0);
  for (int a = 0; a < nodes; ++a) {
    const int row = a / level.cols, col = a % level.cols, lane = col % width;
    const std::ptrdiff_t at = row * level.stride + col - lane;
    const bool free = is_free(row, col);
    if (free) {
      add(a, a, level.ground.data() + kBlock * at + lane, 1.0);
    } else {
      for (int i = 0; i < 3; ++i) matrix_[static_cast<size_t>((3 * a + i) * (padded_ + 1))] = 1.0;
    }
    constexpr int kTo[CoarseGrid::kLinks][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
    for (int k = 0; k < CoarseGrid::kLinks; ++k) {
      const int row2 = row + kTo[k][0], col2 = col + kTo[k][1], b = row2 * level.cols + col2;
      if (row2 >= level.rows || col2 < 0 || col2 >= level.cols) continue;
      const float* link = level.links.data() + kBlock * (CoarseGrid::kLinks * at + k * width) + lane;
      const bool other = is_free(row2, col2);
      if (free) add(a, a, link, 1.0);
      if (other) add(b, b, link, 1.0);
      if (!free || !other) continue;
      add(a, b, link, -1.0);
      add(b, a, link, -1.0);
    }
  }
  // Springs so stiff that inertia is lost in their rounding: without the coarsest grid.
  if (!kernels_.invert(size_, padded_, matrix_.data())) std::fill(matrix_.begin(), matrix_.end(), 0.0);
  for (size_t k = 0; k < matrix_.size(); ++k) inverse_[k] = static_cast<float>(matrix_[k]);
}

void SheetMultigrid::solve_coarsest(Level* level) {
  const Xyz<float> r = level->r.data(), z = level->z.data();
  const float* const from[3] = {r.x, r.y, r.z};
  float* const to[3] = {z.x, z.y, z.z};
  const int nodes = level->rows * level->cols;
  const auto place = [&](int node) { return node / level->cols * level->stride + node % level->cols; };
  for (int k = 0; k < size_; ++k) dense_r_[static_cast<size_t>(k)] = from[k % 3][place(k / 3)];
  kernels_.coarsest(size_, padded_, inverse_.data(), dense_r_.data(), dense_z_.data());
  for (int k = 0; k < 3 * nodes; ++k) to[k % 3][place(k / 3)] = dense_z_[static_cast<size_t>(k)];
}

BandLoop SheetMultigrid::bands_of(size_t level) const {
  const CoarseGrid& grid = grids_[level];
  return {Bands::of(grid.rows, grid.cols), workers_};
}

BandLoop SheetMultigrid::bands_below(size_t level) const {
  const int rows = grids_[level].rows;
  return {Bands{rows, level == 0 ? std::min(bands_.count(), rows) : 1}, workers_};
}

void SheetMultigrid::restrict_to_level(size_t level, Xyz<float> fine, Xyz<float> coarse) {
  const std::ptrdiff_t stride = level == 0 ? stride_ : levels_[level - 1].stride;
  const Xyz<float> row = row_.data();
  bands_below(level).run([&](const RowBand& rows, int scratch) {
    const std::ptrdiff_t at = scratch * 2 * stride_;
    kernels_.restrict_to(grids_[level], stride, free_above(level), fine, coarse, {row.x + at, row.y + at, row.z + at},
                         rows);
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

CoarseGrid SheetMultigrid::grid_with_scratch(size_t level, int scratch) {
  CoarseGrid grid = grids_[level];
  grid.passed += scratch * SheetScratch<float>::kPassed * grid.stride;
  return grid;
}

void SheetMultigrid::correct(Xyz<float> r, Xyz<float> z) {
  const size_t last = levels_.size() - 1;
  for (size_t k = 0; k <= last; ++k) {
    Level& level = levels_[k];
    restrict_to_level(k, k == 0 ? r : levels_[k - 1].y.data(), level.r.data());
    if (k == last) break;
    const BandLoop bands = bands_of(k);
    bands.run([&](const RowBand& rows, int) {
      kernels_.relax_first(grids_[k], kSweep, level.r.data(), level.z.data(), rows);
    });
    bands.run([&](const RowBand& rows, int scratch) {
      kernels_.residue(grid_with_scratch(k, scratch), level.z.data(), level.r.data(), level.y.data(), rows);
    });
  }
  solve_coarsest(&levels_[last]);
  for (size_t k = last; k > 0; --k) {
    Level& finer = levels_[k - 1];
    prolong_from_level(k, finer.z.data());
    bands_of(k - 1).run([&](const RowBand& rows, int scratch) {
      kernels_.relax(grid_with_scratch(k - 1, scratch), kSweep, finer.z.data(), finer.r.data(), finer.y.data(), rows);
    });
    std::swap(finer.z, finer.y);
  }
  prolong_from_level(0, z);
}

}  // namespace deformable_sim
