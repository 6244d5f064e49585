#include "work_precision_budget.h"

#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim::work_precision {

Budget::Budget(double seconds) : total_(seconds), began_(thread_cpu_time()) {}

double Budget::spent() const {
  return thread_cpu_time() - began_;
}

}  // namespace deformable_sim::work_precision
