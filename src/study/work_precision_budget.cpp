#include "work_precision_budget.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <unistd.h>

#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim::work_precision {
namespace {

constexpr int kWidth = 24;          // of the bar
constexpr double kLineEvery = 0.1;  // of the whole, where there is no terminal
constexpr int kLongest = 60;        // characters of what is done now

std::string time_text(double seconds) {
  char text[32];
  const auto whole = static_cast<long>(std::ceil(std::max(0.0, seconds)));
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace

Budget::Budget(double seconds) : total_(seconds), began_(thread_cpu_time()) {}

double Budget::spent() const {
  return thread_cpu_time() - began_;
}

Progress::Manner Progress::fitting() {
  return isatty(STDERR_FILENO) ? Manner::kBar : Manner::kLines;
}

Progress::~Progress() {
  wipe();
}

void Progress::wipe() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void Progress::say(const std::string& line) {
  if (manner_ == Manner::kSilent) return;
  wipe();
  std::fprintf(stderr, "%s\n", line.c_str());
}

void Progress::show(const std::string& what, double done, double left) {
  if (manner_ == Manner::kSilent) return;
  const double share = std::clamp(done / std::max(done + left, 1e-9), 0.0, 1.0);
  const std::string remaining = time_text(left) + " left at most";
  if (manner_ == Manner::kLines) {
    if (last_ >= 0.0 && share < last_ + kLineEvery) return;
    last_ = share;
    std::fprintf(stderr, "%3.0f %%, %s: %s\n", 100.0 * share, remaining.c_str(), what.c_str());
    return;
  }
  const int full = static_cast<int>(std::lround(share * kWidth));
  wipe();
  std::fprintf(stderr, "[%s%s] %s  %.*s", std::string(static_cast<size_t>(full), '#').c_str(),
               std::string(static_cast<size_t>(kWidth - full), '.').c_str(), remaining.c_str(), kLongest, what.c_str());
  std::fflush(stderr);
  drawn_ = true;
}

}  // namespace deformable_sim::work_precision
