#include "build_parts.h"

namespace deformable_sim {
namespace {

void append_links(const std::vector<SpringLink>& links, int first_node, std::vector<SpringLink>* out) {
  for (SpringLink link : links) {
    link.a += first_node;
    link.b += first_node;
    out->push_back(link);
  }
}

}  // namespace

void append_network(const SpringNetwork& network, int first_node, Parts* parts) {
  SpringNetwork placed;
  append_links(network.stretch, first_node, &placed.stretch);
  append_links(network.shear, first_node, &placed.shear);
  append_links(network.bend, first_node, &placed.bend);
  parts->springs.push_back(std::move(placed));
}

void add_strain_edges(const std::vector<SpringLink>& links, Body* body) {
  for (const SpringLink& link : links) {
    body->strain_edges.push_back({{link.a + body->first_node, link.b + body->first_node}, link.rest_length});
  }
}

void place_nodes(const Nodes& rest, const Pose& world_from_body, const Eigen::VectorXd& mass, Body* body,
                 Parts* parts) {
  body->node_count = static_cast<int>(rest.cols());
  parts->positions.push_back((world_from_body.linear() * rest).colwise() + Vec3(world_from_body.translation()));
  parts->masses.push_back(mass);
  parts->node_count += body->node_count;
}

void append_triangles(const std::vector<std::array<int, 3>>& triangles, int first_node,
                      std::vector<std::array<int, 3>>* out) {
  for (const std::array<int, 3>& t : triangles) {
    out->push_back({t[0] + first_node, t[1] + first_node, t[2] + first_node});
  }
}

}  // namespace deformable_sim
