#include "deformable_sim/ros/real_time_priority.h"

#include <cstring>

#include <pthread.h>
#include <sched.h>

namespace deformable_sim {

std::string take_real_time_priority(int priority) {
  if (priority == 0) return "";
  sched_param param{};
  param.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO | SCHED_RESET_ON_FORK, &param);
  if (error == 0) return "";
  return "no real-time priority " + std::to_string(priority) + " (" + std::strerror(error) +
         "): allow it with rtprio in /etc/security/limits.conf";
}

}  // namespace deformable_sim
