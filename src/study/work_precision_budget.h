// CPU time of a study.
#pragma once

namespace deformable_sim::work_precision {

/// What a Progress says of the time that is left of a budget.
inline constexpr char kLeft[] = "left at most";

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

}  // namespace deformable_sim::work_precision
