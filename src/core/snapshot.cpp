#include "deformable_sim/core/snapshot.h"

#include <cmath>

namespace deformable_sim {

Eigen::VectorXf node_strain(const Body& body, const Nodes& x) {
  Eigen::VectorXf strain = Eigen::VectorXf::Zero(body.node_count);
  for (const StrainEdge& e : body.strain_edges) {
    const double value = (x.col(e.node[1]) - x.col(e.node[0])).norm() / e.rest_length - 1.0;
    for (int node : e.node) {
      float& largest = strain[node - body.first_node];
      if (std::abs(value) > std::abs(static_cast<double>(largest))) largest = static_cast<float>(value);
    }
  }
  return strain;
}

Eigen::Matrix3Xf node_normals(const Body& body, const Nodes& x) {
  if (!body.surface) return Eigen::Vector3f(Eigen::Vector3f::UnitZ()).replicate(1, body.node_count);
  return vertex_normals(*body.surface, x.middleCols(body.first_node, body.node_count)).cast<float>();
}

}  // namespace deformable_sim
