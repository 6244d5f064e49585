#include "work_precision_report.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "work_precision_store.h"

namespace deformable_sim::work_precision {
namespace {

std::string number(double value, const char* format = "%.10g") {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '\n' ? ' ' : c;
  }
  return out + "\"";
}

/// JSON has no NaN and no infinity.
std::string json_number(double value) {
  return std::isfinite(value) ? number(value) : "null";
}

/// A share as a percentage with two digits.
std::string percent(double value) {
  return std::isnan(value) ? "-" : number(100.0 * value, "%.2g") + " %";
}

std::string padded(const std::string& text, size_t width) {
  return text + std::string(text.size() < width ? width - text.size() : 1, ' ');
}

std::string field_json(const RowField& field) {
  const bool finite = field.text.find("nan") == std::string::npos && field.text.find("inf") == std::string::npos;
  return quoted(field.name) + ": " + (!field.is_number ? quoted(field.text) : finite ? field.text : "null");
}

std::string row_json(const Row& row) {
  std::string text;
  for (const RowField& field : row_fields(row)) text += (text.empty() ? "{" : ", ") + field_json(field);
  return text + ", \"family\": " + quoted(row.configuration.family()) +
         ", \"settled\": " + (row.settled() ? "true" : "false") + "}";
}

template <typename Range, typename Text>
std::string list(const Range& range, Text&& text, const char* between = ", ") {
  std::string out;
  for (const auto& item : range) out += (out.empty() ? "" : between) + text(item);
  return "[" + out + "]";
}

std::string features_json(const Features& f) {
  return "{\"kind\": " + quoted(f.kind) + ", \"bodies\": " + quoted(f.bodies) +
         ", \"nodes\": " + std::to_string(f.nodes) + ", \"stiffness_ratio\": " + json_number(f.stiffness_ratio) +
         ", \"explicit_steps_per_frame\": " + json_number(f.explicit_steps) +
         ", \"contact\": " + (f.contact ? "true" : "false") +
         ", \"strain_limits\": " + (f.strain_limits ? "true" : "false") + "}";
}

std::string reference_json(const Reference& r) {
  return "{\"method\": " + quoted(r.method) + ", \"reached\": " + json_number(r.reached) +
         ", \"check_method\": " + quoted(r.check_method) + ", \"check_reached\": " + json_number(r.check_reached) +
         ", \"check_difference\": " + json_number(r.check_difference) +
         ", \"resolution\": " + json_number(r.resolution()) + ", \"halvings\": " +
         list(r.halvings, [](const auto& h) { return "[" + json_number(h[0]) + ", " + json_number(h[1]) + "]"; }) + "}";
}

std::string part_json(const Part& part) {
  return "{\"position\": " + json_number(part.position) + ", \"uncertain\": " + json_number(part.uncertain) +
         ", \"how\": " + quoted(part.how) + "}";
}

std::string pick_json(const Pick& pick) {
  return "{\"wanted\": " + json_number(pick.wanted) +
         ", \"run\": " + (pick.row < 0 ? "null" : std::to_string(pick.row)) + ", \"why\": " + quoted(pick.why) + "}";
}

const Row& row_at(const Result& result, int k) {
  return result.rows[static_cast<size_t>(k)];
}

std::string row_line(const Row& row) {
  return padded(row.configuration.family(), 44) + padded(number(1e3 * row.dt, "%.4g"), 11) +
         padded(percent(row.errors.position), 12) + padded(percent(row.errors.position_end), 12) +
         padded(percent(row.errors.energy), 12) + padded(percent(row.errors.measure), 12) +
         padded(percent(row.errors.strain), 12) + padded(percent(row.errors.grasp), 12) +
         padded(number(row.cost.cpu, "%.4g"), 11) + padded(number(row.cost.force_evaluations, "%.4g"), 11) +
         number(row.cost.linear_iterations, "%.4g") + (row.settled() ? "" : "   Newton not converged") + "\n";
}

std::string part_line(const std::string& name, const Part& part) {
  if (std::isnan(part.position)) return name + " not measured: " + part.how + "\n";
  return name + " " + percent(part.position) + " (by " + part.how + ", which is known to " + percent(part.uncertain) +
         ")\n";
}

}  // namespace

std::string text_of(const Result& result) {
  const Reference& r = result.reference;
  std::string out = result.name + ": " + result.title + " (" + result.features.kind + ", " +
                    std::to_string(result.features.nodes) + " nodes, " + number(result.seconds, "%g") + " s)\n";
  out += "reference: " + r.method + "; converged to " + number(r.reached, "%.2g") + "\n";
  out += "check: " + r.check_method + "; converged to " + number(r.check_reached, "%.2g") + ", differs by " +
         number(r.check_difference, "%.2g") + "\n";
  if (!(r.resolution() < 3e-8)) {
    out += "errors below " + number(r.resolution(), "%.2g") + " are below what the reference can resolve\n";
  }
  out += std::to_string(result.rows.size()) +
         " runs; a velocity Verlet step for a frame of 1/60 s: " + number(result.features.explicit_steps, "%.3g") +
         "\n";
  out += part_line("mesh:", result.mesh) + part_line("model:", result.model);
  out += "\n" + padded("not dominated", 44) + padded("dt, ms", 11) + padded("position", 12) + padded("at the end", 12) +
         padded("energy", 12) + padded("size", 12) + padded("strain", 12) + padded("grasp", 12) +
         padded("CPU s/s", 11) + padded("forces/s", 11) + "linear/s\n";
  for (const int k : result.front) out += row_line(row_at(result, k));
  out += "\ncheapest for\n";
  for (const Pick& pick : result.picks) {
    out += padded("  <= " + number(100.0 * pick.wanted, "%g") + " %", 12);
    if (pick.row < 0) {
      out += pick.why + "\n";
      continue;
    }
    const Row& row = row_at(result, pick.row);
    out += row.configuration.family() + ", dt " + number(1e3 * row.dt, "%.4g") +
           " ms: " + number(row.cost.cpu, "%.4g") + " CPU s/s (" + number(1e3 * row.cost.cpu / 60.0, "%.3g") +
           " ms per 1/60 s), error " + percent(row.errors.position) + "\n";
  }
  return out;
}

std::string csv_of(const Result& result) {
  std::vector<const Row*> rows;
  for (const Row& row : result.rows) rows.push_back(&row);
  const auto rank = [](const Row* row) {
    const bool known = row->status == Status::kDone && !std::isnan(row->errors.position);
    return known ? row->errors.position : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const Row* a, const Row* b) { return rank(a) < rank(b); });
  std::string out = row_header() + "\n";
  for (const Row* row : rows) out += row_text(*row) + "\n";
  return out;
}

std::string json_of(const Result& result) {
  return "{\"name\": " + quoted(result.name) + ", \"title\": " + quoted(result.title) +
         ", \"scene\": " + quoted(result.digest) + ", \"program\": " + quoted(result.version) +
         ", \"seconds\": " + json_number(result.seconds) + ",\n \"features\": " + features_json(result.features) +
         ",\n \"reference\": " + reference_json(result.reference) + ",\n \"mesh\": " + part_json(result.mesh) +
         ", \"model\": " + part_json(result.model) + ",\n \"picks\": " + list(result.picks, pick_json) +
         ",\n \"front\": " + list(result.front, [](int k) { return std::to_string(k); }) +
         ",\n \"left_out\": " + list(result.left_out, quoted, ",\n  ") +
         ",\n \"runs\": " + list(result.rows, row_json, ",\n  ") + "}\n";
}

std::string summary_of(const Result& result) {
  const auto run = [&result](int k) {
    const Row& row = row_at(result, k);
    const Configuration& c = row.configuration;
    return "{\"integrator\": " + quoted(c.integrator) + ", \"linear_solver\": " + quoted(c.linear_solver) +
           ", \"newton_iterations\": " + std::to_string(c.newton_iterations) +
           ", \"linear_tolerance\": " + json_number(c.linear_tolerance) +
           ", \"linear_iterations\": " + std::to_string(c.linear_iterations) +
           ", \"precision\": " + quoted(c.precision) + ", \"fraction_of_limit\": " + json_number(c.fraction) +
           ", \"dt\": " + json_number(row.dt) + ", \"cpu_per_second\": " + json_number(row.cost.cpu) +
           ", \"position_error\": " + json_number(row.errors.position) +
           ", \"settled\": " + (row.settled() ? "true" : "false") + "}";
  };
  return "{\"name\": " + quoted(result.name) + ", \"scene\": " + quoted(result.digest) +
         ", \"program\": " + quoted(result.version) + ", \"features\": " + features_json(result.features) +
         ", \"resolution\": " + json_number(result.reference.resolution()) +
         ",\n \"front\": " + list(result.front, run, ",\n  ") + "}\n";
}

}  // namespace deformable_sim::work_precision
