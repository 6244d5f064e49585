// Which configurations are tried, in which steps, and when one is given up.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bench.h"
#include "work_precision_case.h"

namespace deformable_sim::work_precision {

/// A configuration and the numbers of steps in a quarter it is tried with, from coarse to fine.
struct Family {
  Configuration configuration;
  std::vector<int> ladder;
};

/// Usable steps (s) of the explicit schemes by name.
using UsableSteps = std::map<std::string, double>;
/// Measures those of every explicit scheme there is.
UsableSteps usable_steps(const Case& c);

/// Every integrator with every linear solver, and with 1, 2, 4 and as many Newton iterations as convergence takes.
/// Quick: 1 and converged, and fewer steps. Schemes that refuse the scene are left out.
std::vector<Family> plan(const Case& c, const UsableSteps& usable, study::Effort effort);

/// Is it what the solver's part of others' errors is measured against?
bool is_base(const Configuration& k);

/// Runs of one family from coarse to fine: why it should be refined no further. Empty: go on.
///   - four runs diverged in a row
///   - twice in a row another run of at most the same error was kFar times cheaper, and what that costs is worth saving
///   - twice in a row a finer step helped by less than a tenth
///   - the error is below what the reference can resolve
std::string reason_to_stop(const std::vector<Row>& family, const std::vector<Row>& all, double resolution);
constexpr double kFar = 6.0;

/// CPU seconds a run will take, from coarser runs of its family, else at least what a related, cheaper configuration
/// took with the same step. 0: nothing is known.
double expected_cpu(const Configuration& k, const std::vector<Row>& rows);
/// CPU time of a run with an implicit scheme before anything like it was run, s: the order of magnitude.
double guessed_cpu(const Case& c, const Configuration& configuration);

}  // namespace deformable_sim::work_precision
