#include "features.h"

namespace deformable_sim {
namespace {

/// Nodes first, first + stride, ... of `count` nodes.
std::vector<int> sequence(int first, int stride, int count) {
  std::vector<int> nodes;
  for (int k = 0; k < count; ++k) nodes.push_back(first + k * stride);
  return nodes;
}

}  // namespace

std::vector<std::string> feature_names(const BodySpec& body) {
  if (body.kind == BodyKind::kRope) {
    if (body.closed) return {"end_0", "center"};
    return {"end_0", "end_1", "center"};
  }
  if (!body.mesh.empty()) return {"center"};
  return {"corner_0", "corner_1", "corner_2", "corner_3", "edge_0", "edge_1", "edge_2", "edge_3", "center"};
}

Features sheet_features(const TriangleMesh& mesh) {
  if (!mesh.is_grid()) {
    const Vec3 centroid = mesh.rest.rowwise().mean();
    Eigen::Index nearest = 0;
    (mesh.rest.colwise() - centroid).colwise().squaredNorm().minCoeff(&nearest);
    return {{"center", {static_cast<int>(nearest)}}};
  }
  const int rows = mesh.rows, cols = mesh.cols;
  const int corner_1 = cols - 1, corner_2 = rows * cols - 1, corner_3 = (rows - 1) * cols;
  return {{"corner_0", {0}},
          {"corner_1", {corner_1}},
          {"corner_2", {corner_2}},
          {"corner_3", {corner_3}},
          {"edge_0", sequence(0, 1, cols)},
          {"edge_1", sequence(corner_1, cols, rows)},
          {"edge_2", sequence(corner_2, -1, cols)},
          {"edge_3", sequence(corner_3, -cols, rows)},
          {"center", {(rows / 2) * cols + cols / 2}}};
}

Features line_features(const Polyline& line) {
  const int last = static_cast<int>(line.rest.cols()) - 1;
  Features features{{"end_0", {0}}, {"center", {(last + 1) / 2}}};
  if (!line.closed) features["end_1"] = {last};
  return features;
}

}  // namespace deformable_sim
