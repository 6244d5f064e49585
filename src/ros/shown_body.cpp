#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

auto own(const Body& body, const Nodes& nodes) {
  return nodes.middleCols(body.first_node, body.node_count);
}

/// The nodes inside a soft body have no face, so no normal.
void clear_inner_normals(const TriangleMesh& surface, Eigen::Matrix3Xf* normals) {
  std::vector<char> outer(static_cast<std::size_t>(normals->cols()), 0);
  for (const std::array<int, 3>& triangle : surface.triangles) {
    for (const int node : triangle) outer[static_cast<std::size_t>(node)] = 1;
  }
  for (Eigen::Index node = 0; node < normals->cols(); ++node) {
    if (!outer[static_cast<std::size_t>(node)]) normals->col(node).setZero();
  }
}

}  // namespace

const TriangleMesh* shown_surface(const Body& body) {
  return body.skin ? &body.skin->surface() : body.surface.get();
}

int shown_count(const Body& body) {
  return body.skin ? body.skin->vertex_count() : body.node_count;
}

int shown_node(const Body& body, int point) {
  return body.skin ? body.skin->nearest_node()[static_cast<std::size_t>(point)] : point;
}

ShownColumns shown_positions(const Snapshot& snapshot, const Body& body) {
  if (!body.skin) return ShownColumns(snapshot.x, body);
  return ShownColumns(body.skin->positions(own(body, snapshot.x)));
}

ShownColumns shown_velocities(const Snapshot& snapshot, const Body& body) {
  if (!body.skin) return ShownColumns(snapshot.v, body);
  return ShownColumns(body.skin->velocities(own(body, snapshot.x), own(body, snapshot.v)));
}

Eigen::Matrix3Xf shown_normals(const Snapshot& snapshot, const Body& body, const ShownColumns& x) {
  if (body.skin) return vertex_normals(body.skin->surface(), x.all()).cast<float>();
  if (!body.surface) return Eigen::Matrix3Xf::Zero(3, body.node_count);
  Eigen::Matrix3Xf normals = node_normals(body, snapshot.x);
  if (body.volume) clear_inner_normals(*body.surface, &normals);
  return normals;
}

Eigen::VectorXf shown_values(const Body& body, Eigen::VectorXf at_nodes) {
  return body.skin ? body.skin->values(at_nodes) : at_nodes;
}

}  // namespace deformable_sim
