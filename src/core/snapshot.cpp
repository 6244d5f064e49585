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
  Nodes sum = Nodes::Zero(3, body.node_count);
  if (body.surface) {
    for (const auto& t : body.surface->triangles) {
      const Vec3 a = x.col(body.first_node + t[0]), b = x.col(body.first_node + t[1]),
                 c = x.col(body.first_node + t[2]);
      const Vec3 area = (b - a).cross(c - a);
      for (int node : t) sum.col(node) += area;
    }
  }
  Eigen::Matrix3Xf normals(3, body.node_count);
  for (int i = 0; i < body.node_count; ++i) {
    const double length = sum.col(i).norm();
    // A node whose faces cancel or vanish still gets a unit normal: a drawing must not get NaN.
    normals.col(i) = length > 0.0 ? Eigen::Vector3f((sum.col(i) / length).cast<float>()) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

}  // namespace deformable_sim
