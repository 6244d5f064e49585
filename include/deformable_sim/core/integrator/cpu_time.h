// Processor time of the calling thread, for cost reports only: it never enters the physics.
#pragma once

#include <ctime>

namespace deformable_sim {

/// s.
inline double thread_cpu_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace deformable_sim
