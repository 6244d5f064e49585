#include "deformable_sim/core/step_control.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace deformable_sim {
namespace {

constexpr double kSafety = 0.8;  // of the error that is asked for, at which parts are aimed
constexpr double kFewer = 0.6;   // parts become fewer only where so few are enough
constexpr double kForget = 0.1;  // share of a new measurement in the cost

}  // namespace

void StepController::checked(double difference, double dt, int order) {
  const double coarse = difference / (1.0 - std::pow(0.5, order)) / dt;
  // A step that failed in fewer parts says nothing but that they were too few.
  const double ratio = std::isfinite(coarse) ? coarse / (kSafety * settings_.error) : 1e9;
  const double ideal = std::clamp(parts_ * std::pow(ratio, 1.0 / order), 0.5 * parts_, 4.0 * parts_);
  if (ideal > parts_ || ideal <= kFewer * parts_) wanted_ = static_cast<int>(std::ceil(ideal));
  wanted_ = std::clamp(wanted_, 1, kMostParts);
  // Far off: the next step tells more.
  since_check_ = wanted_ >= 2 * parts_ && wanted_ < kMostParts ? kCheckEvery : 0;
  const double enough = parts_ * std::pow(std::max(0.0, coarse) / settings_.floor, 1.0 / order);
  least_ = std::isfinite(enough) ? std::clamp(static_cast<int>(std::ceil(enough)), 1, kMostParts) : kMostParts;
  const int before = parts_;
  choose();
  error_ = coarse * std::pow(static_cast<double>(before) / parts_, order);
}

void StepController::stepped(double cost) {
  ++since_check_;
  if (!(cost > 0.0)) return;
  cost_ = cost_ == 0.0 ? cost : cost_ + kForget * (cost - cost_);
  if (settings_.control != StepControl::kBudget) return;
  affordable_ = std::clamp(static_cast<int>(parts_ * settings_.budget / cost_), 1, kMostParts);
  const int before = parts_;
  choose();
  // What a part takes is taken to stay the same.
  if (parts_ != before) cost_ *= static_cast<double>(parts_) / before;
}

void StepController::choose() {
  parts_ =
      settings_.control == StepControl::kBudget ? std::clamp(affordable_, std::min(least_, wanted_), wanted_) : wanted_;
}

void StepController::pass(Archive* archive) {
  for (int* count : {&parts_, &wanted_, &least_, &affordable_}) {
    archive->pass(count);
    if (*count < 1 || *count > kMostParts) Archive::refuse("a number of parts that is none");
  }
  archive->pass(&since_check_);
  archive->pass_any(&error_);
  archive->pass(&cost_);
}

std::string StepController::complaint() const {
  if (settings_.control == StepControl::kFixed) return "";
  char text[240];
  if (settings_.control == StepControl::kBudget && parts_ > affordable_) {
    std::snprintf(
        text, sizeof text,
        "the budget of %.3g CPU s per simulated s is not held: the error may be %.2g %% a second at most, for "
        "which steps in %d parts take %.3g",
        settings_.budget, 100.0 * settings_.floor, parts_, cost_);
    return text;
  }
  if (settings_.control == StepControl::kBudget && parts_ == 1 && cost_ > settings_.budget) {
    std::snprintf(text, sizeof text,
                  "the budget of %.3g CPU s per simulated s is not held: steps in one part take %.3g, with an error of "
                  "about %.2g %% a second where %.2g %% are asked for",
                  settings_.budget, cost_, 100.0 * error_, 100.0 * settings_.error);
    return text;
  }
  if (!(error_ > settings_.error)) return "";
  if (parts_ < wanted_) {
    std::snprintf(
        text, sizeof text,
        "the error is about %.2g %% a second, %.2g %% are asked for: the budget of %.3g CPU s per simulated s "
        "allows steps in %d parts, not in %d",
        100.0 * error_, 100.0 * settings_.error, settings_.budget, parts_, wanted_);
    return text;
  }
  if (parts_ < kMostParts) return "";
  std::snprintf(
      text, sizeof text,
      "the error is about %.2g %% a second, %.2g %% are asked for: steps in %d parts are the most there are; a "
      "smaller step.dt mends it",
      100.0 * error_, 100.0 * settings_.error, kMostParts);
  return text;
}

}  // namespace deformable_sim
