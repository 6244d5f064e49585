// The coarser grids of a sheet as they are made once: their nodes, and what is projected once.
#include <algorithm>

#include "coarse_lines.h"
#include "deformable_sim/core/grid/sheet_multigrid.h"

namespace deformable_sim {
namespace {

constexpr int kNarrowest = 3;  // rows or columns that are not halved any more
constexpr int kMargin = SheetShape<float>::kMargin;
constexpr int kBlock = CoarseGrid::kBlock;

/// Nodes of a coarser line. An even number of nodes is one cell short of the last coarse node, which lies outside.
int halved(int count) {
  return count / 2 + 1;
}

int entry_of(int row_offset, int col_offset) {
  return row_offset == 0 ? col_offset : 3 + col_offset;
}

/// Adds P^T A P of single entries of A to a coarse stencil. What would reach beyond neighbours is lumped.
class Projection {
 public:
  Projection(bool halves_rows, bool halves_cols, int cols, std::array<std::vector<double>, 5>* to)
      : halves_rows_(halves_rows), halves_cols_(halves_cols), cols_(cols), to_(*to) {}
  /// The entry between (row, col) and (row + down, col + right), and the one between those two the other way round.
  void add(int row, int col, int down, int right, double value) {
    const Parents r = parents(row, halves_rows_), c = parents(col, halves_cols_);
    if (down == 0 && right == 0) return add(r, c, r, c, value);
    const Parents r2 = parents(row + down, halves_rows_), c2 = parents(col + right, halves_cols_);
    add(r, c, r2, c2, value);
    add(r2, c2, r, c, value);
  }

 private:
  void add(const Parents& r, const Parents& c, const Parents& r2, const Parents& c2, double value) {
    for (int a = 0; a < r.count; ++a) {
      for (int b = 0; b < c.count; ++b) {
        for (int a2 = 0; a2 < r2.count; ++a2) {
          for (int b2 = 0; b2 < c2.count; ++b2) {
            put(r.node[a], c.node[b], r2.node[a2], c2.node[b2],
                value * r.weight[a] * c.weight[b] * r2.weight[a2] * c2.weight[b2]);
          }
        }
      }
    }
  }
  void put(int row, int col, int row2, int col2, double value) {
    const auto node = static_cast<size_t>(row * cols_ + col);
    const int down = row2 - row, right = col2 - col;
    if (std::abs(down) > 1 || std::abs(right) > 1) {
      to_[0][node] += value;
    } else if (down > 0 || (down == 0 && right >= 0)) {
      to_[static_cast<size_t>(entry_of(down, right))][node] += value;
    }
  }

  bool halves_rows_, halves_cols_;
  int cols_;
  std::array<std::vector<double>, 5>& to_;
};

}  // namespace

SheetMultigrid::SheetMultigrid(const GridSheet& sheet, const std::vector<double>& mass, const std::vector<char>& free,
                               const Workers* workers)
    : kernels_(coarse_kernels(simd_level())),
      rows_(sheet.rows),
      cols_(sheet.cols),
      bands_(Bands::of(rows_, cols_)),
      workers_(bands_.count() > 1 ? workers : nullptr) {
  stride_ = kMargin + (cols_ + kMargin - 1) / kMargin * kMargin;
  fine_free_ = RowArray<float>(rows_, stride_);
  row_ = XyzArray<float>(scratch_count(), 2 * stride_);
  for (int k = 0; k < rows_ * cols_; ++k) {
    fine_free_.data()[k / cols_ * stride_ + k % cols_] = free[static_cast<size_t>(k)] != 0 ? 1.0f : 0.0f;
  }
  coarsen_finest(sheet, mass, free);
  for (Level& level : levels_) grids_.push_back(level.grid());
  find_shore(free);
  const Level& last = levels_.back();
  size_ = 3 * last.rows * last.cols;
  padded_ = (size_ + kMargin - 1) / kMargin * kMargin;
  inverse_.assign(static_cast<size_t>(size_ * padded_ + kMargin), 0.0f);
  dense_r_.assign(static_cast<size_t>(padded_), 0.0f);
  dense_z_ = dense_r_;
  matrix_.assign(inverse_.size(), 0.0);
}

/// Held nodes whose springs pull at free ones.
void SheetMultigrid::find_shore(const std::vector<char>& free) {
  for (int node = 0; node < rows_ * cols_; ++node) {
    if (free[static_cast<size_t>(node)] != 0) continue;
    const int row = node / cols_, col = node % cols_;
    bool near = false;
    for (int r = std::max(0, row - 2); r <= std::min(rows_ - 1, row + 2); ++r) {
      for (int c = std::max(0, col - 2); c <= std::min(cols_ - 1, col + 2); ++c) {
        near = near || free[static_cast<size_t>(r * cols_ + c)] != 0;
      }
    }
    if (near) shore_.push_back(node);
  }
}

SheetMultigrid::Level SheetMultigrid::below(int rows, int cols) const {
  Level level;
  level.halves_rows = rows > kNarrowest;
  level.halves_cols = cols > kNarrowest;
  level.rows = level.halves_rows ? halved(rows) : rows;
  level.cols = level.halves_cols ? halved(cols) : cols;
  level.stride = kMargin + (level.cols + kMargin - 1) / kMargin * kMargin;
  level.links = RowArray<float>(level.rows, CoarseGrid::kLinks * kBlock * level.stride);
  for (auto* blocks : {&level.ground, &level.inverse, &level.extra}) {
    *blocks = RowArray<float>(level.rows, kBlock * level.stride);
  }
  for (auto* numbers : {&level.free, &level.scalar_sum}) *numbers = RowArray<float>(level.rows, level.stride);
  for (auto& numbers : level.scalar) numbers = RowArray<float>(level.rows, level.stride);
  level.passed = RowArray<float>(scratch_count(), SheetScratch<float>::kPassed * level.stride);
  for (auto* rows_of : {&level.r, &level.z, &level.y}) *rows_of = XyzArray<float>(level.rows, level.stride);
  level.line = (cols + kMargin - 1) / kMargin * kMargin + 4 * kMargin;
  level.space = RowArray<float>(scratch_count(), CoarseKernels::kSpace * level.line);
  level.is_patched.assign(static_cast<size_t>(level.rows * level.cols), 0);
  level.patched.reserve(level.is_patched.size());
  for (Stencil* stencil : {&level.mass, &level.bending}) {
    for (auto& entry : stencil->entry) entry.assign(level.is_patched.size(), 0.0);
  }
  return level;
}

void SheetMultigrid::coarsen_finest(const GridSheet& sheet, const std::vector<double>& mass,
                                    const std::vector<char>& free) {
  Level level = below(rows_, cols_);
  Projection masses(level.halves_rows, level.halves_cols, level.cols, &level.mass.entry);
  Projection bends(level.halves_rows, level.halves_cols, level.cols, &level.bending.entry);
  for (int node = 0; node < rows_ * cols_; ++node) {
    if (free[static_cast<size_t>(node)] == 0) continue;
    const int row = node / cols_, col = node % cols_;
    masses.add(row, col, 0, 0, mass[static_cast<size_t>(node)]);
    if (sheet.bending.empty()) continue;
    const auto& kind = sheet.bending.kind[static_cast<size_t>(sheet.bending.kind_of_row[static_cast<size_t>(row)])];
    for (size_t k = kStencilSize / 2; k < kStencilSize; ++k) {
      const double value = kind[k][static_cast<size_t>(col)];
      const int other = node + kStencil[k][0] * cols_ + kStencil[k][1];
      if (value == 0.0 || free[static_cast<size_t>(other)] == 0) continue;
      bends.add(row, col, kStencil[k][0], kStencil[k][1], value);
    }
  }
  add(std::move(level));
}

void SheetMultigrid::add(Level level) {
  for (int node = 0; node < level.rows * level.cols; ++node) {
    const bool here = level.mass.entry[Stencil::kHere][static_cast<size_t>(node)] > 0.0;
    level.free.data()[node / level.cols * level.stride + node % level.cols] = here ? 1.0f : 0.0f;
  }
  levels_.push_back(std::move(level));
  const Level& made = levels_.back();
  if (made.rows <= kNarrowest && made.cols <= kNarrowest) return;
  Level next = below(made.rows, made.cols);
  for (const auto& [from, to] : {std::pair(&made.mass, &next.mass), std::pair(&made.bending, &next.bending)}) {
    Projection projection(next.halves_rows, next.halves_cols, next.cols, &to->entry);
    for (int node = 0; node < made.rows * made.cols; ++node) {
      for (size_t e = 0; e < kNeighbours.size(); ++e) {
        const double value = from->entry[e][static_cast<size_t>(node)];
        if (value == 0.0) continue;
        projection.add(node / made.cols, node % made.cols, kNeighbours[e][0], kNeighbours[e][1], value);
      }
    }
  }
  add(std::move(next));
}

CoarseGrid SheetMultigrid::Level::grid() {
  return {rows,
          cols,
          stride,
          halves_rows,
          halves_cols,
          free.data(),
          links.data(),
          ground.data(),
          inverse.data(),
          {scalar[0].data(), scalar[1].data(), scalar[2].data(), scalar[3].data()},
          scalar_sum.data(),
          nullptr,
          passed.data()};
}

}  // namespace deformable_sim
