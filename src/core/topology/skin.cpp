#include "deformable_sim/core/topology/skin.h"

#include <algorithm>
#include <utility>

#include "deformable_sim/core/topology/box_tree.h"
#include "deformable_sim/core/topology/upsampling.h"

namespace deformable_sim {

namespace {

/// Time derivative of vertex_normals(): n = a / |a|, so n' = (a' - n n . a') / |a| with a the sum of the face areas.
Nodes normal_rates(const TriangleMesh& mesh, const Skin::NodesIn& x, const Skin::NodesIn& v) {
  Nodes area = Nodes::Zero(3, x.cols()), rate = Nodes::Zero(3, x.cols());
  for (const std::array<int, 3>& t : mesh.triangles) {
    const Vec3 e1 = x.col(t[1]) - x.col(t[0]), e2 = x.col(t[2]) - x.col(t[0]);
    const Vec3 r1 = v.col(t[1]) - v.col(t[0]), r2 = v.col(t[2]) - v.col(t[0]);
    const Vec3 face = e1.cross(e2), face_rate = r1.cross(e2) + e1.cross(r2);
    for (const int node : t) {
      area.col(node) += face;
      rate.col(node) += face_rate;
    }
  }
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double size = area.col(i).norm();
    const Vec3 normal = area.col(i) / size, change = rate.col(i);
    rate.col(i) = size > 0.0 ? Vec3((change - normal * normal.dot(change)) / size) : Vec3(Vec3::Zero());
  }
  return rate;
}

std::vector<int> nearest_nodes(const Nodes& points, const Nodes& nodes) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) boxes.emplace_back(Vec3(nodes.col(i)));
  const BoxTree tree(boxes);
  std::vector<int> nearest;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Vec3 point = points.col(p);
    nearest.push_back(tree.nearest(point, [&](int i) { return (nodes.col(i) - point).squaredNorm(); }).second);
  }
  return nearest;
}

}  // namespace

Skin::Skin(TriangleMesh surface, Embedding embedding, std::shared_ptr<const TriangleMesh> sheet,
           const Nodes& rest_nodes)
    : surface_(std::move(surface)),
      embedding_(std::move(embedding)),
      sheet_(std::move(sheet)),
      nearest_node_(nearest_nodes(surface_.rest, rest_nodes)) {}

Nodes Skin::positions(const NodesIn& x) const {
  Nodes y = x * embedding_.weights;
  if (sheet_) y += vertex_normals(*sheet_, x) * embedding_.weights * embedding_.height.asDiagonal();
  return y;
}

Nodes Skin::velocities(const NodesIn& x, const NodesIn& v) const {
  Nodes rate = v * embedding_.weights;
  if (sheet_) rate += normal_rates(*sheet_, x, v) * embedding_.weights * embedding_.height.asDiagonal();
  return rate;
}

Eigen::VectorXf Skin::values(const Eigen::VectorXf& at_nodes) const {
  Eigen::VectorXf at_vertices(vertex_count());
  for (Eigen::Index p = 0; p < at_vertices.size(); ++p) {
    Eigen::SparseMatrix<double>::InnerIterator i(embedding_.weights, p);
    float least = at_nodes[i.row()], most = least;
    double sum = 0.0;
    for (; i; ++i) {
      const float value = at_nodes[i.row()];
      sum += i.value() * static_cast<double>(value);
      least = std::min(least, value);
      most = std::max(most, value);
    }
    at_vertices[p] = std::clamp(static_cast<float>(sum), least, most);
  }
  return at_vertices;
}

std::shared_ptr<const Skin> make_skin(const TriangleMesh& surface, const TetMesh& volume) {
  return std::make_shared<Skin>(surface, embed_in_volume(surface.rest, volume), nullptr, volume.rest);
}

std::shared_ptr<const Skin> make_skin(const TriangleMesh& surface, std::shared_ptr<const TriangleMesh> sheet) {
  Embedding embedding = embed_in_sheet(surface.rest, *sheet);
  const Nodes& rest = sheet->rest;
  return std::make_shared<Skin>(surface, std::move(embedding), std::move(sheet), rest);
}

std::shared_ptr<const Skin> make_upsampled_skin(const TriangleMesh& grid, int factor) {
  Embedding embedding = upsample(grid, factor);
  TriangleMesh surface = make_grid(1.0, 1.0, (grid.cols - 1) * factor, (grid.rows - 1) * factor);
  surface.rest = grid.rest * embedding.weights;
  return std::make_shared<Skin>(std::move(surface), std::move(embedding), nullptr, grid.rest);
}

}  // namespace deformable_sim
