#include "report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace deformable_sim::study {
namespace {

constexpr double kSame = 1e-6;       // relative: sizes that agree so well are exact
constexpr double kLeastOrder = 0.7;  // slower than that, three sizes do not tell where they go

std::string number(double value, const char* format = "%.5g") {
  if (std::isnan(value)) return "-";
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

/// JSON has no NaN and no infinity.
std::string json_number(double value) {
  return std::isfinite(value) ? number(value, "%.10g") : "null";
}

std::string padded(const std::string& text, size_t width, bool left = false) {
  if (text.size() >= width) return text;
  const std::string space(width - text.size(), ' ');
  return left ? text + space : space + text;
}

std::string percent(std::optional<double> error) {
  if (!error) return "";
  return std::abs(*error) < 5e-5 ? "0.00 %" : number(100.0 * *error, "%+.2f") + " %";
}

std::string order_text(const Row& row) {
  const double p = row.order();
  return std::isinf(p) ? "same" : number(p, "%.1f");
}

/// The three values that Richardson's limit rests on; false when there are fewer or one is missing.
bool last_three(const Row& row, std::array<double, 3>* f) {
  if (row.measured.size() < 3) return false;
  for (size_t k = 0; k < 3; ++k) {
    (*f)[k] = row.measured[row.measured.size() - 3 + k].value;
    if (!std::isfinite((*f)[k])) return false;
  }
  return true;
}

bool agree(const std::array<double, 3>& f) {
  const double scale = kSame * std::abs(f[2]);
  return std::abs(f[1] - f[2]) <= scale && std::abs(f[0] - f[2]) <= scale;
}

std::string row_json(const Row& row) {
  std::string nodes, values, seconds;
  for (size_t m = 0; m < row.measured.size(); ++m) {
    const std::string comma = m ? ", " : "";
    nodes += comma + std::to_string(row.measured[m].nodes);
    values += comma + json_number(row.measured[m].value);
    seconds += comma + json_number(row.measured[m].cpu_seconds);
  }
  return "{\"test\": " + quoted(row.test) + ", \"quantity\": " + quoted(row.quantity) +
         ", \"unit\": " + quoted(row.unit) + ", \"put_in\": " + json_number(row.put_in.value_or(none())) +
         ", \"nodes\": [" + nodes + "], \"measured\": [" + values + "], \"cpu_seconds\": [" + seconds +
         "], \"limit\": " + json_number(row.limit()) +
         ", \"order\": " + (std::isinf(row.order()) ? quoted("same") : json_number(row.order())) +
         ", \"error\": " + json_number(row.error().value_or(none())) + ", \"gap\": " + quoted(row.gap) + "}";
}

std::string curve_json(const Curve& curve) {
  std::string points;
  for (const auto& [x, y] : curve.points) {
    points += (points.empty() ? "[" : ", [") + json_number(x) + ", " + json_number(y) + "]";
  }
  return "{\"name\": " + quoted(curve.name) + ", \"x_label\": " + quoted(curve.x_label) +
         ", \"y_label\": " + quoted(curve.y_label) + ", \"points\": [" + points + "]}";
}

}  // namespace

double none() {
  return std::numeric_limits<double>::quiet_NaN();
}

double Row::order() const {
  std::array<double, 3> f{};
  if (!last_three(*this, &f)) return none();
  if (agree(f)) return std::numeric_limits<double>::infinity();
  const double ratio = (f[0] - f[1]) / (f[1] - f[2]);
  return std::log2(ratio) >= kLeastOrder ? std::log2(ratio) : none();
}

double Row::limit() const {
  std::array<double, 3> f{};
  const double p = order();
  if (!last_three(*this, &f) || std::isnan(p)) return none();
  return std::isinf(p) ? f[2] : f[2] + (f[2] - f[1]) / (std::exp2(p) - 1.0);
}

double Row::best() const {
  const double at_limit = limit();
  if (!std::isnan(at_limit)) return at_limit;
  for (size_t k = measured.size(); k-- > 0;) {
    if (std::isfinite(measured[k].value)) return measured[k].value;
  }
  return none();
}

std::optional<double> Row::error() const {
  const double found = best();
  if (!put_in || *put_in == 0.0 || std::isnan(found)) return std::nullopt;
  return (found - *put_in) / *put_in;
}

std::string text_of(const Report& report) {
  std::string out = report.material + ": " + report.title + " (" + report.kind + "), model " + report.model + "\n";
  out += "source: " + report.source + "\n\n";
  out += padded("test", 22, true) + padded("quantity", 34, true) + padded("unit", 9, true) + padded("put in", 12) +
         padded("coarse", 12) + padded("middle", 12) + padded("fine", 12) + padded("limit", 12) + padded("order", 7) +
         padded("error", 10) + padded("CPU s", 9) + "\n";
  for (const Row& row : report.rows) {
    out += padded(row.test, 22, true) + padded(row.quantity, 34, true) + padded(row.unit, 9, true) +
           padded(row.put_in ? number(*row.put_in) : "", 12);
    double seconds = 0.0;
    for (size_t k = 0; k < 3; ++k) {
      const bool there = k < row.measured.size();
      out += padded(there ? number(row.measured[k].value) : "-", 12);
      seconds += there ? row.measured[k].cpu_seconds : 0.0;
    }
    out += padded(number(row.limit()), 12) + padded(order_text(row), 7) + padded(percent(row.error()), 10) +
           padded(number(seconds, "%.2f"), 9) + "\n";
    if (!row.gap.empty()) out += padded("", 22) + "gap: " + row.gap + "\n";
  }
  for (const std::string& gap : report.gaps) out += "\ngap: " + gap + "\n";
  return out;
}

std::string json_of(const std::vector<Report>& reports) {
  std::string out = "[";
  for (size_t r = 0; r < reports.size(); ++r) {
    const Report& report = reports[r];
    out += std::string(r ? ",\n" : "\n") + "{\"material\": " + quoted(report.material) +
           ", \"title\": " + quoted(report.title) + ", \"kind\": " + quoted(report.kind) +
           ", \"model\": " + quoted(report.model) + ", \"source\": " + quoted(report.source) + ",\n \"rows\": [";
    for (size_t k = 0; k < report.rows.size(); ++k) out += (k ? ",\n  " : "\n  ") + row_json(report.rows[k]);
    out += "],\n \"curves\": [";
    for (size_t k = 0; k < report.curves.size(); ++k) out += (k ? ",\n  " : "\n  ") + curve_json(report.curves[k]);
    out += "],\n \"gaps\": [";
    for (size_t k = 0; k < report.gaps.size(); ++k) out += (k ? ", " : "") + quoted(report.gaps[k]);
    out += "]}";
  }
  return out + "\n]\n";
}

std::string csv_of(const std::vector<Report>& reports) {
  std::string out = "material,model,test,quantity,unit,put_in,nodes,measured,cpu_seconds,limit,order,error\n";
  for (const Report& report : reports) {
    for (const Row& row : report.rows) {
      for (const Measurement& m : row.measured) {
        out += report.material + "," + report.model + "," + row.test + ",\"" + row.quantity + "\"," + row.unit + "," +
               (row.put_in ? number(*row.put_in, "%.10g") : "") + "," + std::to_string(m.nodes) + "," +
               number(m.value, "%.10g") + "," + number(m.cpu_seconds, "%.4f") + "," + number(row.limit(), "%.10g") +
               "," + order_text(row) + "," + (row.error() ? number(*row.error(), "%.6g") : "") + "\n";
      }
    }
  }
  return out;
}

}  // namespace deformable_sim::study
