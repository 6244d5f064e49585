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

/// What a rigid grasp of these nodes (body-local, ascending) holds: beside an end of an open rod with twist its
/// neighbour as well, so that the direction of the end is held; all others as they are.
std::vector<int> clamped_nodes(const Body& body, const std::vector<int>& nodes);

}  // namespace deformable_sim
