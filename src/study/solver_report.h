// How good `solver: auto` is, by its own table.
#pragma once

#include <string>

#include "deformable_sim/scene/solver_choice.h"

namespace deformable_sim::study {

/// One line for each scene and error of the table: what is chosen, its measured error and its cost over the cheapest;
/// then the same with the scene left out of the table, as for a scene that nobody has measured.
std::string solver_report(const SolverTable& table);

}  // namespace deformable_sim::study
