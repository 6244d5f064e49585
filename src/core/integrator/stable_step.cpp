// The step an explicit scheme may take with a body.
#include <algorithm>
#include <limits>

#include "deformable_sim/core/integrator/integrator.h"

namespace deformable_sim {
namespace {

constexpr double kOverdamped = 1e3;  // a damping ratio at which only the damping counts

}  // namespace

double stable_step(const Integrator& integrator, double omega, double damping_rate) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (integrator.stability_limit() == kNever) return kNever;
  // omega dt at a damping ratio zeta is dt rate / (2 zeta).
  const double damped_only =
      damping_rate > 0.0 ? 2.0 * kOverdamped * integrator.stability_limit(kOverdamped) / damping_rate : kNever;
  if (omega <= 0.0) return damped_only;
  return std::min(damped_only, integrator.stability_limit(0.5 * damping_rate / omega) / omega);
}

}  // namespace deformable_sim
