#include "deformable_sim/scene/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace deformable_sim {
namespace {

constexpr int kWidth = 24;          // of the bar
constexpr int kLongest = 60;        // characters of what is done now
constexpr double kLineEvery = 0.1;  // of the whole, where there is no terminal
constexpr std::chrono::milliseconds kBarEvery(100);

std::string time_text(double seconds) {
  char text[32];
  const auto whole = static_cast<long>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
  std::snprintf(text, sizeof text, "%ld:%02ld", whole / 60, whole % 60);
  return text;
}

}  // namespace

Progress::Manner Progress::fitting(bool quiet) {
  if (quiet) return Manner::kSilent;
  return isatty(STDERR_FILENO) ? Manner::kBar : Manner::kLines;
}

Progress::Progress(Manner manner, std::string left, double soon)
    : manner_(manner),
      left_(std::move(left)),
      from_(Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(soon))) {}

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

void Progress::show(const std::string& what, double taken, double left) {
  const Clock::time_point now = Clock::now();
  if (manner_ == Manner::kSilent || now < from_) return;
  const double share = std::clamp(taken / std::max(taken + left, 1e-9), 0.0, 1.0);
  const std::string remaining = time_text(left) + " " + left_;
  if (manner_ == Manner::kLines) {
    if (last_ >= 0.0 && share < last_ + kLineEvery) return;
    last_ = share;
    std::fprintf(stderr, "%3.0f %%, %s: %s\n", 100.0 * share, remaining.c_str(), what.c_str());
    return;
  }
  if (drawn_ && now < drawn_at_ + kBarEvery) return;
  const int full = static_cast<int>(std::lround(share * kWidth));
  wipe();
  std::fprintf(stderr, "[%s%s] %s  %.*s", std::string(static_cast<size_t>(full), '#').c_str(),
               std::string(static_cast<size_t>(kWidth - full), '.').c_str(), remaining.c_str(), kLongest, what.c_str());
  std::fflush(stderr);
  drawn_ = true;
  drawn_at_ = now;
}

}  // namespace deformable_sim
