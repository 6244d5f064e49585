// The bending energy of a plate by differences on a regular grid.
//
//   E = sum over nodes a/2 (D11 kxx^2 + 2 D12 kxx kyy + D22 kyy^2) + sum over cells dx dy/2 D33 (2 kxy)^2
//   kxx = (x_left - 2 x + x_right) / dx^2, kyy alike, kxy = (x_00 - x_10 - x_01 + x_11) / (dx dy)
//
// a = dx dy. On a free edge a is half of that, there is no kxx or no kyy across the edge, and the sheet takes the
// curvature across that leaves no moment, which lowers D11 to D11 - D12^2 / D22: a narrow strip is as stiff as one of
// any width.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/bending_law.h"

namespace deformable_sim {
namespace {

/// Of up to four nodes, 1/m^2 each.
struct Curvature {
  std::array<std::pair<int, double>, 4> by;
  size_t count = 0;
};

class Weights {
 public:
  explicit Weights(int node_count) : of_(static_cast<size_t>(node_count)) {}

  /// E += factor/2 a.b, b.a to follow or the same.
  void add(double factor, const Curvature& a, const Curvature& b) {
    for (size_t i = 0; i < a.count; ++i) {
      for (size_t j = 0; j < b.count; ++j) {
        if (a.by[i].first < b.by[j].first) {
          at(a.by[i].first, b.by[j].first) -= factor * a.by[i].second * b.by[j].second;
        }
      }
    }
  }

  /// By a, then b.
  std::vector<QuadraticWeight> list() {
    std::vector<QuadraticWeight> all;
    all.reserve(kNeighbours * of_.size());
    for (size_t a = 0; a < of_.size(); ++a) {
      Row& row = of_[a];
      std::sort(row.to.begin(), row.to.begin() + static_cast<std::ptrdiff_t>(row.count));
      for (size_t k = 0; k < row.count; ++k) {
        if (row.to[k].second != 0.0) all.push_back({static_cast<int>(a), row.to[k].first, row.to[k].second});
      }
    }
    return all;
  }

 private:
  static constexpr size_t kNeighbours = 6;  // of higher number: two along the row, three in the next, one after that
  struct Row {
    std::array<std::pair<int, double>, kNeighbours> to;
    size_t count = 0;
  };

  double& at(int a, int b) {
    Row& row = of_[static_cast<size_t>(a)];
    for (size_t k = 0; k < row.count; ++k) {
      if (row.to[k].first == b) return row.to[k].second;
    }
    assert(row.count < kNeighbours);
    row.to[row.count] = {b, 0.0};
    return row.to[row.count++].second;
  }

  std::vector<Row> of_;
};

Curvature second_difference(int node, int step, double h) {
  const double w = 1.0 / (h * h);
  return {{{{node - step, w}, {node, -2.0 * w}, {node + step, w}}}, 3};
}

}  // namespace

std::vector<QuadraticWeight> grid_bending_weights(const TriangleMesh& grid, const BendingMaterial& material) {
  check_material(material);
  if (!grid.is_grid()) throw InputError("bending by differences needs a grid");
  const Mat3 d = plate_stiffness(material);
  const double dx = (grid.rest.col(1) - grid.rest.col(0)).norm();
  const double dy = (grid.rest.col(grid.cols) - grid.rest.col(0)).norm();
  const double area = dx * dy;
  Weights weights(grid.rows * grid.cols);
  for (int row = 0; row < grid.rows; ++row) {
    for (int col = 0; col < grid.cols; ++col) {
      const int node = row * grid.cols + col;
      const bool along_x = col > 0 && col + 1 < grid.cols, along_y = row > 0 && row + 1 < grid.rows;
      const Curvature kxx = along_x ? second_difference(node, 1, dx) : Curvature();
      const Curvature kyy = along_y ? second_difference(node, grid.cols, dy) : Curvature();
      if (along_x && along_y) {
        weights.add(area * d(0, 0), kxx, kxx);
        weights.add(area * d(1, 1), kyy, kyy);
        weights.add(area * d(0, 1), kxx, kyy);
        weights.add(area * d(0, 1), kyy, kxx);
      } else if (along_x) {
        weights.add(0.5 * area * (d(0, 0) - d(0, 1) * d(0, 1) / d(1, 1)), kxx, kxx);
      } else if (along_y) {
        weights.add(0.5 * area * (d(1, 1) - d(0, 1) * d(0, 1) / d(0, 0)), kyy, kyy);
      }
      if (row + 1 == grid.rows || col + 1 == grid.cols) continue;
      const double w = 2.0 / area;  // of 2 kxy
      const Curvature twist{{{{node, w}, {node + 1, -w}, {node + grid.cols, -w}, {node + grid.cols + 1, w}}}, 4};
      weights.add(area * d(2, 2), twist, twist);
    }
  }
  return weights.list();
}

}  // namespace deformable_sim
