// The simulation's thread before all others of the machine.
#pragma once

#include <string>

namespace deformable_sim {

/// Schedules the calling thread by SCHED_FIFO at this priority (1 ... 99; 0: nothing is changed): it is interrupted by
/// threads of a higher one alone. Threads that it begins are not. Needs CAP_SYS_NICE or a limit (rtprio) that allows
/// it. Returns why not, or nothing.
std::string take_real_time_priority(int priority);

}  // namespace deformable_sim
