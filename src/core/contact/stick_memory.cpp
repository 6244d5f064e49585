#include "deformable_sim/core/contact/stick_memory.h"

#include <utility>

namespace deformable_sim {

void StickMemory::begin_step() {
  if (remembered_ == Remembered::kOfLastPart) std::swap(start_, last_);
  remembered_ = Remembered::kOfStart;
}

void StickMemory::restart() {
  remembered_ = Remembered::kOfStart;
  stored_.clear();
}

void StickMemory::forget() {
  start_.clear();
  restart();
}

void StickMemory::end_part() {
  std::swap(last_, stored_);
  stored_.clear();
  remembered_ = Remembered::kOfLastPart;
}

}  // namespace deformable_sim
