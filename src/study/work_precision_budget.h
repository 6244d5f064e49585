// CPU time of a study, and what is said while it runs.
#pragma once

#include <string>

namespace deformable_sim::work_precision {

/// Counts the CPU time of this thread.
class Budget {
 public:
  explicit Budget(double seconds);
  double total() const { return total_; }
  double spent() const;
  double left() const { return total_ - spent(); }

 private:
  double total_, began_;
};

/// A bar on a terminal, lines elsewhere, or nothing.
class Progress {
 public:
  enum class Manner { kBar, kLines, kSilent };
  /// kBar on a terminal, kLines elsewhere.
  static Manner fitting();
  explicit Progress(Manner manner) : manner_(manner) {}
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// A line that stays.
  void say(const std::string& line);
  /// What is done now; `left` CPU seconds to go, at most.
  void show(const std::string& what, double done, double left);

 private:
  void wipe();
  Manner manner_;
  bool drawn_ = false;
  double last_ = -1.0;  // share of the last line
};

}  // namespace deformable_sim::work_precision
