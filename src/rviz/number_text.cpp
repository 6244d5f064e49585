#include "deformable_sim/rviz/number_text.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

/// Of three significant digits; no more than two, so that small numbers end as 0.00.
int decimals_of(double value) {
  const double rounded = std::abs(value) * (1 + 5e-4);
  return rounded < 1 ? 2 : std::clamp(2 - static_cast<int>(std::floor(std::log10(rounded))), 0, 2);
}

}  // namespace

QString with_unit(double value, const QString& unit) {
  if (!std::isfinite(value)) return QStringLiteral("-");
  if (unit.isEmpty() || unit == QLatin1String("%")) {
    return QString::number(value, 'f', decimals_of(value)) + (unit.isEmpty() ? "" : " %");
  }
  constexpr int kSteps = 9;
  const QString prefixes[kSteps] = {"p", "n", "µ", "m", "", "k", "M", "G", "T"};
  const double size = std::abs(value);
  if (size < 1e-12) return "0 " + unit;
  // Rounded to three digits first, so that 999.9 becomes 1 k and not 1e+03.
  const double rounded = size * (1 + 5e-4);
  const int step = std::clamp(static_cast<int>(std::floor(std::log10(rounded) / 3)), -4, 4);
  const double scaled = value / std::pow(1000.0, step);
  return QString::number(scaled, 'f', decimals_of(scaled)) + " " + prefixes[step + 4] + unit;
}

}  // namespace deformable_sim
