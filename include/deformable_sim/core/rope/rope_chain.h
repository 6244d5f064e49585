// What the solver of ropes needs to know of a line of nodes: its springs and its bending, place by place.
#pragma once

#include <optional>
#include <vector>

#include "deformable_sim/core/energy/energy.h"

namespace deformable_sim {

/// Nodes first_node + k in a row, none of which is tied to more than two on either side. What is missing has stiffness
/// zero.
struct RopeChain {
  struct Spring {
    double stiffness = 0.0;  // N/m
    double length = 1.0;     // m
    double damping = 0.0;    // N s/m
  };
  /// M = stiffness (k + damping dk/dt), k = before d + behind d', d from the node to the next one, d' from there on.
  struct Joint {
    double before = 0.0, behind = 0.0;  // 1/m^2
    double stiffness = 0.0;             // N m^3
    double damping = 0.0;               // s
  };
  int first_node = 0, count = 0;
  std::vector<Spring> links;  // count: from node k to k + 1
  std::vector<Spring> spans;  // count, or none at all: from node k to k + 2
  std::vector<Joint> joints;  // count: at node k + 1
  bool damped = false;
};

/// The chains that springs and line bending make of n nodes, in their order: the terms among `energies` that are
/// neither are not looked at. None where a closed loop, a net, or two springs side by side are among them.
std::optional<std::vector<RopeChain>> find_chains(int n, const std::vector<const Energy*>& energies);

/// Springs between two nodes, or line bending.
bool is_chain_term(const Energy& energy);

}  // namespace deformable_sim
