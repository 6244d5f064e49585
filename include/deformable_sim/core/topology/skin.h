// What is shown of a body in place of its nodes: a finer surface that follows them.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/topology/embedding.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// A visual surface carried by the nodes of a body. Immutable; takes no part in the simulation. Node arguments are
/// body-local, one column per node.
class Skin {
 public:
  using NodesIn = Eigen::Ref<const Nodes>;

  /// `sheet`: whose normals the heights of the embedding refer to; may be null without any. `rest_nodes`: m.
  Skin(TriangleMesh surface, Embedding embedding, std::shared_ptr<const TriangleMesh> sheet, const Nodes& rest_nodes);

  /// Rest shape and triangles; rows and cols when it is a grid.
  const TriangleMesh& surface() const { return surface_; }
  int vertex_count() const { return static_cast<int>(surface_.rest.cols()); }
  /// The simulated node nearest to each vertex at rest.
  const std::vector<int>& nearest_node() const { return nearest_node_; }

  /// Vertex positions, m.
  Nodes positions(const NodesIn& x) const;
  /// Vertex velocities, m/s: the time derivative of positions(), turning normals included.
  Nodes velocities(const NodesIn& x, const NodesIn& v) const;
  /// Values given at the nodes (strain, stress, force), at the vertices: the same weights, kept within the values of
  /// the nodes that have one, for smooth weights may be negative.
  Eigen::VectorXf values(const Eigen::VectorXf& at_nodes) const;

 private:
  TriangleMesh surface_;
  Embedding embedding_;
  std::shared_ptr<const TriangleMesh> sheet_;
  std::vector<int> nearest_node_;
};

/// A surface carried by tetrahedra; both at rest in the same frame, m. See embed_in_volume().
std::shared_ptr<const Skin> make_skin(const TriangleMesh& surface, const TetMesh& volume);
/// A surface carried by a sheet; both at rest in the same frame, m. See embed_in_sheet().
std::shared_ptr<const Skin> make_skin(const TriangleMesh& surface, std::shared_ptr<const TriangleMesh> sheet);
/// A grid, smooth and `factor` times as fine. See upsample().
std::shared_ptr<const Skin> make_upsampled_skin(const TriangleMesh& grid, int factor);

}  // namespace deformable_sim
