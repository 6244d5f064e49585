// Which nodes a grasp takes.
#pragma once

#include <vector>

#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/model.h"

namespace deformable_sim {

/// Body-local nodes, ascending, each once, at least one. x: world positions of all nodes.
/// Throws InputError: nothing in reach (and how far the nearest node is), node out of range or twice, unknown feature
/// (and which exist), invalid pose, radius or size.
std::vector<int> select_nodes(const Body& body, const Nodes& x, const Selection& selection);

}  // namespace deformable_sim
