// A solution that has converged in time, and how well that is known.
#pragma once

#include "deformable_sim/scene/progress.h"
#include "work_precision_budget.h"
#include "work_precision_errors.h"
#include "work_precision_run.h"

namespace deformable_sim::work_precision {

/// Difference of positions (relative RMS) between two halvings at which a reference is good enough.
constexpr double kReferenceGoal = 1e-8;

/// a + (a - b) / (2^order - 1): of two solutions with steps h (a) and 2 h (b) what an error C h^order leaves
/// [Richardson 1911].
Trajectory extrapolated(const Trajectory& a, const Trajectory& b, int order);

/// A scheme whose step is halved until nothing changes.
struct Refinement {
  Trajectory best;
  double reached = kNone;  // relative RMS of the positions between the last two; NaN with fewer than two
  int steps = 0;           // in a quarter, the last
  int extrapolations = 0;  // of the best
  std::vector<std::array<double, 2>> halvings;  // dt (s), difference to the one before
  std::string stopped;                          // why before the goal; empty: it was reached
};

/// Halves the step until two solutions, or their extrapolations to the step zero (order, order + 1), differ by less
/// than `goal`, or the next halving would cost more than what is left of `most` CPU seconds.
Refinement refine(const Case& c, const Yardstick& yardstick, Configuration configuration, int order, double tight,
                  double goal, double most);

/// By rk4 from its stability limit down where that is affordable and no strain limit forbids it, else by tr_bdf2 with
/// converged Newton; the golden table where there is one. Checked by a scheme of another family. `verlet_step` (s) is
/// the usable step of velocity Verlet.
Reference find_reference(const Case& c, const Yardstick& yardstick, double verlet_step, double most,
                         Progress* progress);

}  // namespace deformable_sim::work_precision
