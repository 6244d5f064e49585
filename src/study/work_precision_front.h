// Of all runs, those worth choosing.
#pragma once

#include <vector>

#include "work_precision.h"

namespace deformable_sim::work_precision {

/// The errors asked for, relative RMS of the positions: 2 %, 1 %, 0.3 %, 0.1 %, 0.01 %.
const std::vector<double>& wanted_errors();

/// Rows that finished and have a smaller error than every cheaper one, from cheap to dear. Errors below `resolution`
/// count as that, and such that differ by rounding as equal.
std::vector<int> pareto_front(const std::vector<Row>& rows, double resolution);

/// The cheapest row for each wanted error.
std::vector<Pick> picks(const std::vector<Row>& rows, double resolution);

}  // namespace deformable_sim::work_precision
