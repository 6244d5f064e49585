// What a command that takes its time says while it runs.
#pragma once

#include <chrono>
#include <string>

namespace deformable_sim {

/// On standard error: a bar on a terminal, a line for each tenth elsewhere, or nothing.
class Progress {
 public:
  enum class Manner { kBar, kLines, kSilent };
  /// kSilent if quiet, else kBar on a terminal and kLines elsewhere.
  static Manner fitting(bool quiet);
  /// `left`: what is said after the time that is left. `soon` (s): nothing is shown before.
  explicit Progress(Manner manner, std::string left = "left", double soon = 2.0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// A line that stays.
  void say(const std::string& line);
  /// What is done now; seconds that were taken, and that are left.
  void show(const std::string& what, double taken, double left);
  /// Takes the bar away, for what is printed next.
  void wipe();

 private:
  using Clock = std::chrono::steady_clock;
  Manner manner_;
  std::string left_;
  Clock::time_point from_, drawn_at_;
  bool drawn_ = false;
  double last_ = -1.0;  // share of the last line
};

}  // namespace deformable_sim
