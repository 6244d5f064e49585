// The parts of the error that no solver can help: the mesh and the model.
#pragma once

#include "work_precision_errors.h"
#include "work_precision_run.h"

namespace deformable_sim::work_precision {

/// Nodes of `fine` at the places of all points of `coarse`; empty where one has none. Both at the start, m.
std::vector<int> common_nodes(const Nodes& coarse, const Nodes& fine, int points);

/// This mesh against one with cells and segments half as large, at the nodes they share. Both solved by `with`, whose
/// own error is `uncertain`.
Part mesh_part(const Case& c, const Yardstick& yardstick, const Reference& reference, const Row& with, double tight,
               double most);

/// Springs against the membrane or the other way round.
Part model_part(const Case& c, const Yardstick& yardstick, const Reference& reference, const Row& with, double tight,
                double most);

}  // namespace deformable_sim::work_precision
