// The bending energy of a plate by differences on a regular grid.
//
//   E = sum over nodes a/2 (D11 kxx^2 + 2 D12 kxx kyy + D22 kyy^2) + sum over cells dx dy/2 D33 (2 kxy)^2
//   kxx = (x_left - 2 x + x_right) / dx^2, kyy alike, kxy = (x_00 - x_10 - x_01 + x_11) / (dx dy)
//
// a = dx dy. On a free edge a is half of that, there is no kxx or no kyy across the edge, and the sheet takes the
// curvature across that leaves no moment, which lowers D11 to D11 - D12^2 / D22: a narrow strip is as stiff as one of
// any width.
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/bending_law.h"

namespace deformable_sim {
namespace {

using Curvature = std::vector<std::pair<int, double>>;  // of nodes, 1/m^2 each

class Weights {
 public:
  /// E += factor/2 a.b, b.a to follow or the same.
  void add(double factor, const Curvature& a, const Curvature& b) {
    for (const auto& [i, by_i] : a) {
      for (const auto& [j, by_j] : b) {
        if (i < j) weight_[{i, j}] -= factor * by_i * by_j;
      }
    }
  }
  std::vector<QuadraticWeight> list() const {
    std::vector<QuadraticWeight> all;
    for (const auto& [pair, weight] : weight_) {
      if (weight != 0.0) all.push_back({pair[0], pair[1], weight});
    }
    return all;
  }

 private:
  std::map<std::array<int, 2>, double> weight_;
};

Curvature second_difference(int node, int step, double h) {
  const double w = 1.0 / (h * h);
  return {{node - step, w}, {node, -2.0 * w}, {node + step, w}};
}

}  // namespace

std::vector<QuadraticWeight> grid_bending_weights(const TriangleMesh& grid, const BendingMaterial& material) {
  check_material(material);
  if (!grid.is_grid()) throw InputError("bending by differences needs a grid");
  const Mat3 d = plate_stiffness(material);
  const double dx = (grid.rest.col(1) - grid.rest.col(0)).norm();
  const double dy = (grid.rest.col(grid.cols) - grid.rest.col(0)).norm();
  const double area = dx * dy;
  Weights weights;
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
      const Curvature twist{{node, w}, {node + 1, -w}, {node + grid.cols, -w}, {node + grid.cols + 1, w}};
      weights.add(area * d(2, 2), twist, twist);
    }
  }
  return weights.list();
}

}  // namespace deformable_sim
