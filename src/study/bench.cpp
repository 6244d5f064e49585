#include "bench.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim::study {

Row row_of(const Bench& bench, const std::string& test, const std::string& quantity, const std::string& unit,
           std::optional<double> put_in, const std::vector<int>& sizes,
           const std::function<Measurement(int)>& measure) {
  Row row;
  row.test = test;
  row.quantity = quantity;
  row.unit = unit;
  row.put_in = put_in;
  for (const int size : sizes) {
    if (bench.tell) bench.tell(test);
    const double start = thread_cpu_time();
    Measurement m = measure(size);
    m.cpu_seconds = thread_cpu_time() - start;
    if (std::isnan(m.value)) row.gap = "the statics did not settle at every size: nothing is measured there";
    row.measured.push_back(m);
  }
  return row;
}

void check_model(const std::string& model, const std::vector<std::string>& models, const std::string& kind) {
  if (std::find(models.begin(), models.end(), model) != models.end()) return;
  std::string list;
  for (const std::string& name : models) list += (list.empty() ? "" : ", ") + name;
  throw InputError("no model '" + model + "' of a " + kind + "; there is " + list + ", and all", Code::kNotFound);
}

double overhang_at_41_5(double first_guess, const std::function<Overhang(double)>& hang, Overhang* last) {
  const double wanted = 41.5 * kPi / 180.0;
  // In log(length) against log(tan(chord)) the curve is almost straight.
  const auto miss = [&](double length) {
    *last = hang(length);
    return last->settled ? std::log(std::tan(std::clamp(last->chord, 1e-6, 1.57))) - std::log(std::tan(wanted))
                         : none();
  };
  double low = first_guess, at_low = miss(low), high = low, at_high = at_low;
  while (at_low > 0.0 && low > first_guess / 50.0) at_low = miss(low /= 1.5);
  while (at_high < 0.0 && high < first_guess * 20.0) at_high = miss(high *= 1.5);
  if (!(at_low <= 0.0 && at_high >= 0.0)) return none();
  for (int k = 0; k < 40 && high / low > 1.0 + 1e-9; ++k) {
    double share = at_high > at_low ? -at_low / (at_high - at_low) : 0.5;
    if (k % 3 == 2) share = 0.5;
    const double middle = low * std::pow(high / low, std::clamp(share, 0.02, 0.98)), at_middle = miss(middle);
    if (std::isnan(at_middle)) return none();
    if (std::abs(at_middle) < 1e-6) return middle;
    (at_middle < 0.0 ? low : high) = middle;
    (at_middle < 0.0 ? at_low : at_high) = at_middle;
  }
  return std::sqrt(low * high);
}

}  // namespace deformable_sim::study
