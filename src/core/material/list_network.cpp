// Arbitrary networks, from a list of links.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {

SpringNetwork list_network(const Nodes& nodes, std::vector<SpringLink> links) {
  std::map<std::pair<int, int>, size_t> seen;
  for (size_t k = 0; k < links.size(); ++k) {
    SpringLink& link = links[k];
    const auto refuse = [&](const std::string& why) {
      throw InputError("link " + std::to_string(k) + " (" + std::to_string(link.a) + " - " + std::to_string(link.b) +
                       ") " + why);
    };
    const auto n = static_cast<int>(nodes.cols());
    if (std::min(link.a, link.b) < 0 || std::max(link.a, link.b) >= n)
      refuse("names a node that does not exist; nodes are 0 to " + std::to_string(n - 1));
    if (link.a == link.b) refuse("joins a node to itself");
    const auto [other, is_new] = seen.insert({std::minmax(link.a, link.b), k});
    if (!is_new) refuse("is there already, as link " + std::to_string(other->second));
    if (!(link.stiffness > 0.0) || !std::isfinite(link.stiffness)) refuse("must have a stiffness > 0 (N/m)");
    if (!(link.damping >= 0.0) || !std::isfinite(link.damping)) refuse("must have a damping >= 0 (N s/m)");
    if (!(link.rest_length >= 0.0) || !std::isfinite(link.rest_length))
      refuse("must have a rest length > 0 (m), or 0 for the distance of its nodes");
    if (link.rest_length == 0.0) link.rest_length = (nodes.col(link.b) - nodes.col(link.a)).norm();
    if (link.rest_length == 0.0) refuse("joins nodes that coincide: give it a rest length > 0 (m)");
  }
  SpringNetwork network;
  network.stretch = std::move(links);
  return network;
}

}  // namespace deformable_sim
