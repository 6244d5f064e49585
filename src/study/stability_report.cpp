// The map as tables.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "stability_map.h"

namespace deformable_sim::stability {
namespace {

constexpr size_t kShown = 40;  // cells that are wrong in silence, of which there should be none
constexpr Class kClasses[] = {Class::kRight,   Class::kWrong, Class::kDiverged,
                              Class::kRefused, Class::kSlow,  Class::kUnknown};

/// Empty where there is no number; infinity is "inf".
std::string number(double value, const char* form = "%.6g") {
  if (std::isnan(value)) return "";
  char text[40];
  std::snprintf(text, sizeof text, form, value);
  return text;
}

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

std::string padded(std::string text, size_t width) {
  if (text.size() < width) text.resize(width, ' ');
  return text;
}

const char* way_text(Stepper::Way way) {
  switch (way) {
    case Stepper::Way::kScheme:
      return "scheme";
    case Stepper::Way::kWorld:
      return "world";
    case Stepper::Way::kAuto:
      return "auto";
    case Stepper::Way::kAutoAnyStep:
      break;
  }
  return "auto_any_step";
}

/// A world's own choice that is wrong, or cannot be told, and does not say so.
bool is_silently_wrong(const Row& row) {
  const bool by_default = row.stepper.way == Stepper::Way::kAuto || row.stepper.way == Stepper::Way::kAutoAnyStep;
  return by_default && !row.outcome.says &&
         (row.outcome.verdict == Class::kWrong || row.outcome.verdict == Class::kDiverged);
}

void add_counts(const Map& map, std::ostringstream* text) {
  std::vector<std::string> order;
  std::map<std::string, std::array<int, 7>> counts;
  for (const Row& row : map.rows) {
    const std::string name = row.stepper.text() + " | " + row.column.body + ", " + row.column.slice;
    if (counts.count(name) == 0) order.push_back(name);
    std::array<int, 7>& count = counts[name];
    for (size_t k = 0; k < std::size(kClasses); ++k) count[k] += row.outcome.verdict == kClasses[k] ? 1 : 0;
    const bool off = row.outcome.verdict == Class::kWrong || row.outcome.verdict == Class::kDiverged;
    count[6] += off && row.outcome.says ? 1 : 0;
  }
  *text << padded("who steps | body, slice", 52);
  for (const Class c : kClasses) *text << padded(class_text(c), 10);
  *text << "wrong or diverged, and says so\n";
  for (const std::string& name : order) {
    *text << padded(name, 52);
    for (size_t k = 0; k < std::size(kClasses); ++k) *text << padded(std::to_string(counts[name][k]), 10);
    *text << counts[name][6] << "\n";
  }
}

void add_limits(const Map& map, std::ostringstream* text) {
  if (map.limits.empty()) return;
  *text << "\nstep limits, s: body, scheme, damping ratio, theory, measured, measured / theory\n";
  for (const Limit& limit : map.limits) {
    *text << padded(limit.body, 8) << padded(limit.integrator, 20) << padded(number(limit.ratio), 6)
          << padded(number(limit.theory), 14);
    if (limit.theory > 0.0) {
      *text << padded(number(limit.measured), 14) << number(limit.measured / limit.theory, "%.4f") << "\n";
    } else {
      *text << "unstable at any step\n";
    }
  }
}

}  // namespace

std::string csv_of(const Map& map) {
  std::ostringstream text;
  text << "slice,body,way,integrator,linear_solver,step_s,stiffness_Pa,damping_s,mass_ratio,aspect,class,error,says,"
          "limit_s,reference_uncertain,simulated_s,cpu_s,chosen,note\n";
  for (const Row& row : map.rows) {
    const Point& at = row.column.at;
    text << row.column.slice << ',' << row.column.body << ',' << way_text(row.stepper.way) << ','
         << row.stepper.integrator << ',' << row.stepper.linear_solver << ',' << number(row.dt) << ','
         << number(at.stiffness) << ',' << number(at.damping) << ',' << number(at.mass_ratio) << ','
         << number(at.aspect) << ',' << class_text(row.outcome.verdict) << ',' << number(row.outcome.error, "%.3g")
         << ',' << (row.outcome.says ? 1 : 0) << ',' << number(row.limit) << ',' << number(row.uncertain, "%.2g") << ','
         << number(row.outcome.reached) << ',' << number(row.outcome.cpu, "%.2g") << ',' << quoted(row.chosen) << ','
         << quoted(row.outcome.note) << "\n";
  }
  return text.str();
}

std::string limits_csv_of(const Map& map) {
  std::ostringstream text;
  text << "body,integrator,damping_ratio,theory_s,fastest_motion_s,measured_s\n";
  for (const Limit& limit : map.limits) {
    text << limit.body << ',' << limit.integrator << ',' << number(limit.ratio) << ',' << number(limit.theory, "%.9g")
         << ',' << number(limit.fast, "%.9g") << ',' << number(limit.measured, "%.9g") << "\n";
  }
  return text.str();
}

std::string text_of(const Map& map) {
  std::ostringstream text;
  add_counts(map, &text);
  add_limits(map, &text);
  std::vector<const Row*> silent;
  for (const Row& row : map.rows) {
    if (is_silently_wrong(row)) silent.push_back(&row);
  }
  text << "\nthe default solver, off by more than 1 % in silence: " << silent.size() << " cells\n";
  for (size_t k = 0; k < std::min(silent.size(), kShown); ++k) {
    const Row& row = *silent[k];
    const Point& at = row.column.at;
    text << "  " << row.column.body << ", " << row.column.slice << ": step " << number(row.dt) << " s, E "
         << number(at.stiffness) << ", damping " << number(at.damping) << " s, mass ratio " << number(at.mass_ratio)
         << ", aspect " << number(at.aspect) << ": " << class_text(row.outcome.verdict) << ", error "
         << number(100.0 * row.outcome.error, "%.3g") << " % with " << row.chosen << "\n";
  }
  if (map.left_out > 0) text << "\nthe budget left out " << map.left_out << " cells\n";
  return text.str();
}

}  // namespace deformable_sim::stability
