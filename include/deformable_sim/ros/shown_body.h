// What is shown of a body: its nodes, or the vertices of its skin.
#pragma once

#include <utility>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Triangles and rest shape of what is shown; null for a rope.
const TriangleMesh* shown_surface(const Body& body);
/// Number of points shown.
int shown_count(const Body& body);
/// The node of the body that a point shows, or the one nearest to it.
int shown_node(const Body& body, int point);

/// Positions or velocities, one column a point shown: a view of the snapshot's, or a skin's, which it keeps.
class ShownColumns {
 public:
  ShownColumns(const Nodes& of_all_nodes, const Body& body)
      : data_(of_all_nodes.data() + 3 * body.first_node), cols_(body.node_count) {}
  explicit ShownColumns(Nodes of_skin) : kept_(std::move(of_skin)), data_(kept_.data()), cols_(kept_.cols()) {}
  ShownColumns(ShownColumns&&) = default;
  ShownColumns(const ShownColumns&) = delete;

  Eigen::Index cols() const { return cols_; }
  Eigen::Map<const Vec3> col(Eigen::Index i) const { return Eigen::Map<const Vec3>(data_ + 3 * i); }
  Eigen::Map<const Nodes> all() const { return Eigen::Map<const Nodes>(data_, 3, cols_); }

 private:
  Nodes kept_;
  const double* data_;
  Eigen::Index cols_;
};

/// m.
ShownColumns shown_positions(const Snapshot& snapshot, const Body& body);
/// m/s.
ShownColumns shown_velocities(const Snapshot& snapshot, const Body& body);
/// Unit; zero where a point is on no face: of a rope, inside a soft body. `x`: shown_positions().
Eigen::Matrix3Xf shown_normals(const Snapshot& snapshot, const Body& body, const ShownColumns& x);
/// Values given at the nodes, at the points.
Eigen::VectorXf shown_values(const Body& body, Eigen::VectorXf at_nodes);

}  // namespace deformable_sim
