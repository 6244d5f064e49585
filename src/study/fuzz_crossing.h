// Surfaces that crossed, found by looking at every edge and every triangle: slow, and of another mind than the core.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/model.h"

namespace deformable_sim::fuzz {

/// Names the bodies of an edge (of a sheet, skin or rope) and a triangle that cross at x and that Body::touches keeps
/// apart; empty: none. Not looked at: where one node of the five is free,
/// as held ones go where they are told.
///
/// held  by node of the model, not 0: held.
std::string find_crossing(const Model& model, const Nodes& x, const std::vector<char>& held);

}  // namespace deformable_sim::fuzz
