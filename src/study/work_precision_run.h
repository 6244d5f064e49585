// One run of a case: states at the quarters, and what they cost.
#pragma once

#include "work_precision_case.h"

namespace deformable_sim::work_precision {

struct Run {
  Status status = Status::kDone;
  std::string note;
  double dt = 0.0;  // s
  Trajectory trajectory;
  Cost cost;
  double cpu_seconds = 0.0;  // of this thread, all steps
};

/// Settings of a configuration. `tight` is the Newton tolerance (m/s^2) that converged means.
SolverSettings settings_of(const Case& c, const Configuration& configuration, double tight);

/// What grasps feel is asked for after each step, with the clock stopped. That disturbs the timing of steps that take
/// microseconds.
enum class Pulls { kMeasured, kLeftOut };

/// Runs to the end, until no finite state is found, or until it has cost `most` CPU seconds.
Run run(const Case& c, const Configuration& configuration, double tight, double most, Pulls pulls = Pulls::kMeasured);

/// CPU seconds the whole run would take, from its beginning in steps of about dt (s) for at most `most` CPU seconds:
/// what one long step divided into many costs cannot be stopped.
double probe(const Case& c, const Configuration& configuration, double dt, double most);

/// The step (s) a world with this explicit scheme divides longer ones into at the start; to 5 %. Infinite for schemes
/// without a limit.
double usable_step(const Case& c, const std::string& integrator);

/// Newton tolerance (m/s^2) of a converged solve, above what rounding leaves of forces: eps omega^2 size, omega the
/// highest frequency, found from the usable step (s) of velocity Verlet. Never below `least`.
double tight_tolerance(const Case& c, double verlet_step, double least);

}  // namespace deformable_sim::work_precision
