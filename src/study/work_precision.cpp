#include "work_precision.h"

#include <algorithm>
#include <cstdio>

#include "deformable_sim/core/error.h"

namespace deformable_sim::work_precision {
namespace {

constexpr std::array<const char*, 3> kStatus = {"done", "diverged", "stopped"};
constexpr double kWholeLimit = 0.95;
constexpr double kTrust = 3.0;  // of a difference between halvings

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

}  // namespace

std::string Configuration::newton_text() const {
  if (is_explicit()) return "-";
  return is_converged() ? "converged" : std::to_string(newton_iterations);
}

std::string Configuration::linear_text() const {
  if (is_explicit()) return "-";
  if (!is_iterative()) return linear_solver;
  return linear_solver + " " + short_number(linear_tolerance) + " x " + std::to_string(linear_iterations);
}

std::string Configuration::family() const {
  std::string text = integrator;
  if (!is_explicit()) text += ", " + linear_text() + ", Newton " + newton_text();
  if (precision != "double") text += ", " + precision;
  if (fraction != kWholeLimit) text += ", " + short_number(fraction) + " of the limit";
  return text;
}

std::string Configuration::key() const {
  return family() + ", " + precision + ", " + std::to_string(steps);
}

std::string status_text(Status status) {
  return kStatus[static_cast<size_t>(status)];
}

Status status_of(const std::string& text) {
  for (size_t k = 0; k < kStatus.size(); ++k) {
    if (text == kStatus[k]) return static_cast<Status>(k);
  }
  throw InputError("'" + text + "' is no status of a run");
}

double Reference::resolution() const {
  if (std::isnan(reached)) return std::numeric_limits<double>::infinity();
  const double own = kTrust * reached;
  const bool disagree = check_difference > kTrust * (check_reached + reached);
  return disagree ? std::max(own, check_difference) : own;
}

}  // namespace deformable_sim::work_precision
