#include "deformable_sim/core/grid/grid_sheet.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

constexpr double kSame = 1e-9;  // relative: rounding of lengths and stiffnesses that are meant to be equal

bool same(double a, double b) {
  return std::abs(a - b) <= kSame * std::max(std::abs(a), std::abs(b));
}

/// Reads the links of a network into a GridSheet; `good` stays true as long as they fit.
class Reader {
 public:
  Reader(const TriangleMesh& mesh, GridSheet* sheet) : rows_(mesh.rows), cols_(mesh.cols), sheet_(sheet) {}

  bool good = true;

  void read_springs(const SpringNetwork& network) {
    if (!network.stretch.empty()) {
      const SpringLink& first = network.stretch.front();
      sheet_->damping_time = first.damping / first.stiffness;
    }
    read_lines(network.stretch, 1, &sheet_->warp, &sheet_->weft);
    read_lines(network.bend, 2, &sheet_->warp_bend, &sheet_->weft_bend);
    read_diagonals(network.shear);
  }

  void read_bending(const std::vector<QuadraticWeight>& weights) {
    if (weights.empty()) return;
    std::vector<GridStencil::Row> rows(static_cast<size_t>(rows_));
    for (auto& row : rows) row.fill(std::vector<double>(static_cast<size_t>(cols_), 0.0));
    const auto add = [&](int a, int b, double value) {
      const std::array<int, 2> offset{b / cols_ - a / cols_, b % cols_ - a % cols_};
      const auto* place = std::find(kStencil.begin(), kStencil.end(), offset);
      good = good && place != kStencil.end();
      if (!good) return;
      rows[static_cast<size_t>(a / cols_)][static_cast<size_t>(place - kStencil.begin())]
          [static_cast<size_t>(a % cols_)] += value;
    };
    for (const QuadraticWeight& w : weights) {
      add(w.a, w.b, -w.weight);
      add(w.b, w.a, -w.weight);
      add(w.a, w.a, w.weight);
      add(w.b, w.b, w.weight);
    }
    if (!good) return;
    double largest = 0.0;
    for (const QuadraticWeight& w : weights) largest = std::max(largest, std::abs(w.weight));
    for (const auto& row : rows) sheet_->bending.kind_of_row.push_back(kind_of(row, kSame * largest));
  }

 private:
  bool fits(const SpringLink& link, double* length) {
    if (*length == 0.0) *length = link.rest_length;
    good = good && same(link.rest_length, *length) &&
           std::abs(link.damping - sheet_->damping_time * link.stiffness) <= kSame * link.damping;
    return good;
  }

  /// Links over `step` cells along rows and columns.
  void read_lines(const std::vector<SpringLink>& links, int step, GridSprings* warp, GridSprings* weft) {
    if (links.empty() || !good) return;
    std::vector<double> in_rows(static_cast<size_t>(rows_ * cols_), 0.0), in_columns = in_rows;
    size_t warps = 0, wefts = 0;
    for (const SpringLink& link : links) {
      const int a = std::min(link.a, link.b), b = std::max(link.a, link.b);
      if (b - a == step && a / cols_ == b / cols_) {
        if (!fits(link, &warp->length)) return;
        in_rows[static_cast<size_t>(a)] = link.stiffness;
        ++warps;
      } else if (b - a == step * cols_) {
        if (!fits(link, &weft->length)) return;
        in_columns[static_cast<size_t>(a)] = link.stiffness;
        ++wefts;
      } else {
        good = false;
        return;
      }
    }
    good = warps == static_cast<size_t>(std::max(0, rows_ * (cols_ - step))) &&
           wefts == static_cast<size_t>(std::max(0, (rows_ - step) * cols_));
    if (!good) return;
    split(in_rows, cols_ - step, rows_, 1, cols_, warp);
    split(in_columns, rows_ - step, cols_, cols_, 1, weft);
  }

  /// k(a, b) = along(a) across(b), with across = 1 in the middle.
  void split(const std::vector<double>& k, int count, int lines, int stride, int line_stride, GridSprings* springs) {
    if (count <= 0) return;
    const int line = lines / 2, place = count / 2;
    const auto at = [&](int a, int b) { return k[static_cast<size_t>(a * stride + b * line_stride)]; };
    for (int a = 0; a < count; ++a) springs->along.push_back(at(a, line));
    for (int b = 0; b < lines; ++b) springs->across.push_back(at(place, b) / at(place, line));
    for (int a = 0; a < count; ++a) {
      for (int b = 0; b < lines; ++b) {
        good = good && same(at(a, b), springs->along[static_cast<size_t>(a)] * springs->across[static_cast<size_t>(b)]);
      }
    }
  }

  void read_diagonals(const std::vector<SpringLink>& links) {
    if (links.empty() || !good) return;
    sheet_->shear = links.front().stiffness;
    for (const SpringLink& link : links) {
      const int a = std::min(link.a, link.b), b = std::max(link.a, link.b);
      good = good && b / cols_ - a / cols_ == 1 && std::abs(b % cols_ - a % cols_) == 1 &&
             same(link.stiffness, sheet_->shear);
      if (!good || !fits(link, &sheet_->shear_length)) return;
    }
    good = links.size() == static_cast<size_t>(2 * (rows_ - 1) * (cols_ - 1));
  }

  int kind_of(const GridStencil::Row& row, double rounding) {
    auto& kinds = sheet_->bending.kind;
    for (size_t k = 0; k < kinds.size(); ++k) {
      bool equal = true;
      for (size_t o = 0; o < row.size() && equal; ++o) {
        for (size_t c = 0; c < row[o].size() && equal; ++c) equal = std::abs(row[o][c] - kinds[k][o][c]) <= rounding;
      }
      if (equal) return static_cast<int>(k);
    }
    kinds.push_back(row);
    return static_cast<int>(kinds.size()) - 1;
  }

  int rows_, cols_;
  GridSheet* sheet_;
};

}  // namespace

std::optional<GridSheet> make_grid_sheet(const TriangleMesh& mesh, const SpringNetwork& network,
                                         const std::vector<QuadraticWeight>& bending, double bending_damping,
                                         int first_node) {
  if (!mesh.is_grid() || network.stretch.empty()) return std::nullopt;
  GridSheet sheet;
  sheet.first_node = first_node;
  sheet.rows = mesh.rows;
  sheet.cols = mesh.cols;
  sheet.bending_damping = bending_damping;
  Reader reader(mesh, &sheet);
  reader.read_springs(network);
  reader.read_bending(bending);
  if (!reader.good) return std::nullopt;
  return sheet;
}

}  // namespace deformable_sim
