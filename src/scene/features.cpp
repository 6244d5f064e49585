#include "features.h"

namespace deformable_sim {
namespace {

/// Nodes first, first + stride, ... of `count` nodes.
std::vector<int> sequence(int first, int stride, int count) {
  std::vector<int> nodes;
  for (int k = 0; k < count; ++k) nodes.push_back(first + k * stride);
  return nodes;
}

int nearest_node(const Nodes& rest, const Vec3& point) {
  Eigen::Index nearest = 0;
  (rest.colwise() - point).colwise().squaredNorm().minCoeff(&nearest);
  return static_cast<int>(nearest);
}

}  // namespace

std::vector<std::string> feature_names(const BodySpec& body) {
  if (body.kind == BodyKind::kRope) {
    if (body.closed) return {"end_0", "center"};
    return {"end_0", "end_1", "center"};
  }
  if (body.kind == BodyKind::kSoft) {
    std::vector<std::string> names{"face_x0", "face_x1", "face_y0", "face_y1", "face_z0", "face_z1", "center"};
    for (int k = 0; k < 8 && body.soft.box_size; ++k) names.push_back("corner_" + std::to_string(k));
    return names;
  }
  if (!body.mesh.empty()) return {"center"};
  return {"corner_0", "corner_1", "corner_2", "corner_3", "edge_0", "edge_1", "edge_2", "edge_3", "center"};
}

Features sheet_features(const TriangleMesh& mesh) {
  if (!mesh.is_grid()) {
    return {{"center", {nearest_node(mesh.rest, mesh.rest.rowwise().mean())}}};
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

Features solid_features(const TetMesh& mesh, Corners corners) {
  const Vec3 low = mesh.rest.rowwise().minCoeff(), high = mesh.rest.rowwise().maxCoeff();
  const double on_side = 1e-6 * (high - low).maxCoeff();
  Features features{{"center", {nearest_node(mesh.rest, 0.5 * (low + high))}}};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("face_") + "xyz"[axis];
    for (int i = 0; i < static_cast<int>(mesh.rest.cols()); ++i) {
      if (mesh.rest(axis, i) - low[axis] <= on_side) features[name + "0"].push_back(i);
      if (high[axis] - mesh.rest(axis, i) <= on_side) features[name + "1"].push_back(i);
    }
  }
  for (int k = 0; k < 8 && corners == Corners::kOfBounds; ++k) {
    const Vec3 corner((k & 1) ? high.x() : low.x(), (k & 2) ? high.y() : low.y(), (k & 4) ? high.z() : low.z());
    features["corner_" + std::to_string(k)] = {nearest_node(mesh.rest, corner)};
  }
  return features;
}

}  // namespace deformable_sim
