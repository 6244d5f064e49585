// What the bench found: one row a test, at three mesh sizes, and the curves behind it.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace deformable_sim::study {

/// One measurement at one mesh size.
struct Measurement {
  int nodes = 0;
  double value = 0.0;        // NaN: the test has no result at this size
  double cpu_seconds = 0.0;  // of this thread
};

struct Row {
  std::string test;      // traction, shear, ...
  std::string quantity;  // what is measured
  std::string unit;
  std::optional<double> put_in;  // none: an outcome, not a parameter
  std::vector<Measurement> measured;
  std::string gap;  // why it cannot agree, or what is missing

  /// Of the last three sizes, each with elements half as large: f + C h^p through them. NaN with fewer, or where
  /// they do not converge with p of 0.7 at least; the last value where they agree to 1e-6.
  double limit() const;
  /// p; infinity where the sizes agree to 1e-6.
  double order() const;
  /// (best - put in) / put in, best = limit where there is one, else the last value.
  std::optional<double> error() const;
  double best() const;
};

struct Curve {
  std::string name, x_label, y_label;
  std::vector<std::array<double, 2>> points;
};

struct Report {
  std::string material, title, kind, model, source;
  std::vector<Row> rows;
  std::vector<Curve> curves;
  std::vector<std::string> gaps;  // what the model cannot represent at all
};

std::string text_of(const Report& report);
std::string json_of(const std::vector<Report>& reports);
std::string csv_of(const std::vector<Report>& reports);

/// NaN.
double none();

}  // namespace deformable_sim::study
