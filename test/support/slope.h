// Observed order of convergence.
#pragma once

#include <cmath>
#include <vector>

namespace deformable_sim::test {

/// Least-squares slope of log(error) over log(step).
inline double log_slope(const std::vector<double>& step, const std::vector<double>& error) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const auto n = static_cast<double>(step.size());
  for (size_t k = 0; k < step.size(); ++k) {
    const double x = std::log(step[k]), y = std::log(error[k]);
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

}  // namespace deformable_sim::test
