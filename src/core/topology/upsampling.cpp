#include "deformable_sim/core/topology/upsampling.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

namespace {

struct Weight {
  int node;
  double value;
};

/// What each of the (count - 1) factor + 1 points on a line of `count` nodes takes of them.
std::vector<std::vector<Weight>> line_weights(int count, int factor) {
  std::vector<std::vector<Weight>> all;
  for (int point = 0; point <= (count - 1) * factor; ++point) {
    const int cell = std::min(point / factor, count - 2);
    const double t = static_cast<double>(point - cell * factor) / factor, t2 = t * t, t3 = t2 * t;
    const std::array<double, 4> spline{{0.5 * (-t + 2.0 * t2 - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3),
                                        0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)}};
    const int first = std::max(0, cell - 1), last = std::min(count - 1, cell + 2);
    std::array<double, 4> near{};  // of the nodes from `first` on: no other has a weight
    const auto at = [&near, first](int node) -> double& { return near[static_cast<size_t>(node - first)]; };
    for (int k = 0; k < 4; ++k) {
      const int node = cell - 1 + k;
      const double value = spline[static_cast<size_t>(k)];
      if (node >= 0 && node < count) {
        at(node) += value;
        continue;
      }
      // Beyond the rim: 3 x_0 - 3 x_1 + x_2, or 2 x_0 - x_1 where there is no third.
      const int rim = node < 0 ? 0 : count - 1, inward = node < 0 ? 1 : -1;
      const bool parabola = count > 2;
      at(rim) += (parabola ? 3.0 : 2.0) * value;
      at(rim + inward) += (parabola ? -3.0 : -1.0) * value;
      if (parabola) at(rim + 2 * inward) += value;
    }
    std::vector<Weight> sparse;
    for (int node = first; node <= last; ++node) {
      if (at(node) != 0.0) sparse.push_back({node, at(node)});
    }
    all.push_back(std::move(sparse));
  }
  return all;
}

}  // namespace

Embedding upsample(const TriangleMesh& grid, int factor) {
  if (!grid.is_grid()) throw InputError("only a grid can be upsampled, not a mesh of triangles");
  if (factor < 1 || factor > kMaxUpsampling) {
    throw InputError("upsampling by " + std::to_string(factor) + "; allowed: 1 ... " + std::to_string(kMaxUpsampling));
  }
  const auto along_rows = line_weights(grid.rows, factor), along_cols = line_weights(grid.cols, factor);
  std::vector<Eigen::Triplet<double>> entries;
  int point = 0;
  for (const std::vector<Weight>& row : along_rows) {
    for (const std::vector<Weight>& col : along_cols) {
      for (const Weight& r : row) {
        for (const Weight& c : col) entries.emplace_back(r.node * grid.cols + c.node, point, r.value * c.value);
      }
      ++point;
    }
  }
  Embedding embedding;
  embedding.weights.resize(grid.rest.cols(), point);
  embedding.weights.setFromTriplets(entries.begin(), entries.end());
  embedding.weights.makeCompressed();
  return embedding;
}

}  // namespace deformable_sim
