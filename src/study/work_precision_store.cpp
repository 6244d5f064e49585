#include "work_precision_store.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "work_precision_case.h"

namespace deformable_sim::work_precision {
namespace {

const char kWho[] = "scene,program,";

std::string exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

double number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0') throw InputError("'" + text + "' is no number");
  return value;
}

std::string one_word(std::string text) {
  for (char& c : text) {
    if (c == ',' || c == '\n' || c == '\r') c = ';';
  }
  return text;
}

struct Column {
  const char* name;
  bool is_number;
  std::function<std::string(const Row&)> get;
  std::function<void(const std::string&, Row*)> set;
};

/// A number at `place` of a row.
template <typename Place>
Column number_column(const char* name, Place place) {
  return {name, true, [place](const Row& row) { return exact(place(const_cast<Row&>(row))); },
          [place](const std::string& text, Row* row) { place(*row) = number(text); }};
}

template <typename Place>
Column integer_column(const char* name, Place place) {
  return {name, true, [place](const Row& row) { return std::to_string(place(const_cast<Row&>(row))); },
          [place](const std::string& text, Row* row) { place(*row) = static_cast<int>(number(text)); }};
}

template <typename Place>
Column text_column(const char* name, Place place) {
  return {name, false, [place](const Row& row) { return one_word(place(const_cast<Row&>(row))); },
          [place](const std::string& text, Row* row) { place(*row) = text; }};
}

#define AT(member)         \
  [](Row & row) -> auto& { \
    return row.member;     \
  }

std::vector<Column> columns() {
  return {text_column("integrator", AT(configuration.integrator)),
          text_column("linear_solver", AT(configuration.linear_solver)),
          integer_column("newton_iterations", AT(configuration.newton_iterations)),
          number_column("linear_tolerance", AT(configuration.linear_tolerance)),
          integer_column("linear_iterations", AT(configuration.linear_iterations)),
          text_column("precision", AT(configuration.precision)),
          number_column("fraction_of_limit", AT(configuration.fraction)),
          integer_column("steps_per_quarter", AT(configuration.steps)),
          number_column("dt_s", AT(dt)),
          {"status", false, [](const Row& row) { return status_text(row.status); },
           [](const std::string& text, Row* row) { row->status = status_of(text); }},
          text_column("note", AT(note)),
          number_column("cpu_per_second", AT(cost.cpu)),
          number_column("first_step_cpu_s", AT(cost.first_step)),
          number_column("force_evaluations_per_second", AT(cost.force_evaluations)),
          number_column("newton_per_second", AT(cost.newton_iterations)),
          number_column("linear_per_second", AT(cost.linear_iterations)),
          number_column("unconverged_share", AT(cost.unconverged)),
          number_column("run_cpu_s", AT(cpu_seconds)),
          number_column("position_error", AT(errors.position)),
          number_column("position_error_end", AT(errors.position_end)),
          number_column("energy_error", AT(errors.energy)),
          number_column("measure_error", AT(errors.measure)),
          number_column("strain_error", AT(errors.strain)),
          number_column("grasp_error", AT(errors.grasp)),
          number_column("time_error", AT(time_error)),
          number_column("solver_error", AT(solver_error))};
}

#undef AT

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> words(1);
  for (const char c : line) {
    if (c == ',') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

}  // namespace

std::string program_version() {
  return digest_of(content_of("/proc/self/exe"));
}

std::string row_header() {
  std::string text;
  for (const Column& column : columns()) text += (text.empty() ? "" : ",") + std::string(column.name);
  return text;
}

std::string row_text(const Row& row) {
  std::string text;
  bool first = true;
  for (const Column& column : columns()) {
    text += (first ? "" : ",") + column.get(row);
    first = false;
  }
  return text;
}

std::vector<RowField> row_fields(const Row& row) {
  std::vector<RowField> fields;
  for (const Column& column : columns()) fields.push_back({column.name, column.get(row), column.is_number});
  return fields;
}

Row row_of_text(const std::string& line) {
  const std::vector<std::string> words = split(line);
  const std::vector<Column> all = columns();
  if (words.size() != all.size()) throw InputError("'" + line + "' is no run");
  Row row;
  for (size_t k = 0; k < all.size(); ++k) all[k].set(words[k], &row);
  return row;
}

RunLog::RunLog(const std::string& path, const std::string& digest, const std::string& version, Start start)
    : who_(digest + "," + version + ",") {
  bool there = false;
  if (start == Start::kResume) {
    there = std::ifstream(path).good();
    if (there) read(path);
  }
  stream_.open(path, there ? std::ios::app : std::ios::trunc);
  if (!there) stream_ << kWho << row_header() << "\n" << std::flush;
  if (!stream_) throw InputError(path + ": cannot be written");
}

void RunLog::read(const std::string& path) {
  std::ifstream stream(path);
  std::string line;
  std::getline(stream, line);
  if (line != kWho + row_header()) throw InputError(path + ": has other columns; start without --resume");
  while (std::getline(stream, line)) {
    // A line cut short by the end of the last study is run again.
    if (stream.eof() || line.compare(0, who_.size(), who_) != 0) continue;
    const Row row = row_of_text(line.substr(who_.size()));
    rows_[row.configuration.key()] = row;
  }
}

const Row* RunLog::find(const Configuration& configuration) const {
  const auto found = rows_.find(configuration.key());
  return found == rows_.end() ? nullptr : &found->second;
}

void RunLog::append(const Row& row) {
  if (stream_.is_open()) stream_ << who_ << row_text(row) << "\n" << std::flush;
}

void write_reference(const std::string& path, const std::string& digest, const std::string& version,
                     const Reference& r) {
  std::ofstream stream(path);
  stream << digest << "," << version << "\n"
         << r.method << "\n"
         << r.check_method << "\n"
         << exact(r.reached) << " " << exact(r.check_reached) << " " << exact(r.check_difference) << "\n"
         << r.halvings.size();
  for (const auto& halving : r.halvings) stream << " " << exact(halving[0]) << " " << exact(halving[1]);
  stream << "\n" << r.trajectory.size() << "\n";
  for (const Sample& s : r.trajectory) {
    stream << s.x.cols() << " " << s.pull.cols() << " " << exact(s.kinetic) << " " << exact(s.stored) << "\n";
    for (Eigen::Index k = 0; k < s.x.size(); ++k) stream << exact(s.x.data()[k]) << " ";
    stream << "\n";
    for (Eigen::Index k = 0; k < s.pull.size(); ++k) stream << exact(s.pull.data()[k]) << " ";
    stream << "\n";
  }
  if (!stream.flush()) throw InputError(path + ": cannot be written");
}

bool read_reference(const std::string& path, const std::string& digest, const std::string& version,
                    Reference* reference) {
  std::ifstream stream(path);
  std::string line;
  if (!std::getline(stream, line) || line != digest + "," + version) return false;
  Reference r;
  std::getline(stream, r.method);
  std::getline(stream, r.check_method);
  // Streams do not read "nan".
  const auto value = [&stream] {
    std::string word;
    stream >> word;
    return stream ? number(word) : kNone;
  };
  const auto count = [&value] { return static_cast<size_t>(std::max(0.0, value())); };
  r.reached = value();
  r.check_reached = value();
  r.check_difference = value();
  r.halvings.resize(std::min<size_t>(count(), 64));
  for (auto& halving : r.halvings) halving = {value(), value()};
  r.trajectory.resize(std::min<size_t>(count(), kQuarters));
  for (Sample& s : r.trajectory) {
    const auto nodes = static_cast<Eigen::Index>(count()), grasps = static_cast<Eigen::Index>(count());
    if (!stream) return false;
    s.kinetic = value();
    s.stored = value();
    s.x.resize(3, nodes);
    s.pull.resize(6, grasps);
    for (Eigen::Index k = 0; k < s.x.size(); ++k) s.x.data()[k] = value();
    for (Eigen::Index k = 0; k < s.pull.size(); ++k) s.pull.data()[k] = value();
  }
  if (!stream) return false;
  *reference = std::move(r);
  return true;
}

}  // namespace deformable_sim::work_precision
