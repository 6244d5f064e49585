#include "schema.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <locale>
#include <sstream>

namespace deformable_sim {
namespace {

const char* kind_of(const YamlValue& value) {
  switch (value.kind) {
    case YamlValue::Kind::kNull:
      return "nothing";
    case YamlValue::Kind::kList:
      return "a list";
    case YamlValue::Kind::kMap:
      return "a map";
    case YamlValue::Kind::kScalar:
      break;
  }
  return value.quoted ? "quoted text" : "text";
}

/// What was found, short enough for one line: the text itself or the kind of value.
std::string found(const YamlValue& value) {
  if (value.kind != YamlValue::Kind::kScalar) return kind_of(value);
  return (value.quoted ? "the quoted text '" : "'") + value.text.substr(0, 40) +
         (value.text.size() > 40 ? "...'" : "'");
}

void expect_scalar(const YamlValue& value, const std::string& path, const std::string& what) {
  if (value.kind != YamlValue::Kind::kScalar) refuse(value, path, "must be " + what + ", not " + kind_of(value));
}

bool names_non_finite(std::string text) {
  if (!text.empty() && (text[0] == '+' || text[0] == '-')) text.erase(0, 1);
  if (!text.empty() && text[0] == '.') text.erase(0, 1);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text == "nan" || text == "inf" || text == "infinity";
}

int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// The nearest of the words, or empty when none is near enough to be a slip of the pen.
std::string nearest(const std::string& word, const std::vector<std::string>& words) {
  if (word.size() > 60) return "";
  std::string best;
  int best_distance = std::max(2, static_cast<int>(word.size()) / 3) + 1;
  for (const std::string& candidate : words) {
    const int distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string hint(const std::string& word, const std::vector<std::string>& words) {
  const std::string near = nearest(word, words);
  return (near.empty() ? "; allowed: " : "; did you mean '" + near + "'? Allowed: ") + join(words);
}

std::vector<std::string> present(const YamlValue& map, const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& name : names) {
    if (map.find(name)) result.push_back(name);
  }
  return result;
}

}  // namespace

std::string Range::text() const {
  return open ? "> " + format_number(low) + ", <= " + format_number(high)
              : format_number(low) + " ... " + format_number(high);
}

std::vector<std::string> nearest_words(const std::string& word, const std::vector<std::string>& words, size_t count) {
  if (word.empty() || word.size() > 60) return {};
  std::vector<std::pair<int, std::string>> ranked;
  for (const std::string& candidate : words) {
    const bool contained = candidate.find(word) != std::string::npos || word.find(candidate) != std::string::npos;
    const int distance = contained ? 0 : edit_distance(word, candidate);
    if (distance <= std::max(2, static_cast<int>(word.size()) / 3)) ranked.emplace_back(distance, candidate);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> near;
  for (size_t k = 0; k < std::min(count, ranked.size()); ++k) near.push_back(ranked[k].second);
  return near;
}

std::string format_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

std::string format_vector(const double* values, size_t count) {
  std::string text = "[";
  for (size_t k = 0; k < count; ++k) text += (k ? ", " : "") + format_number(values[k]);
  return text + "]";
}

std::string join(const std::vector<std::string>& words, const std::string& separator) {
  std::string text;
  for (size_t k = 0; k < words.size(); ++k) text += (k ? separator : "") + words[k];
  return text;
}

double read_number(const YamlValue& value, const std::string& path, const Range& range) {
  expect_scalar(value, path, "a number");
  if (!value.quoted && names_non_finite(value.text)) {
    refuse(value, path, "must be finite, not '" + value.text + "'; allowed: " + range.text());
  }
  double number = 0.0;
  std::istringstream stream(value.text);
  stream.imbue(std::locale::classic());
  stream >> number;
  if (value.quoted || value.text.find_first_not_of("0123456789+-.eE") != std::string::npos || !stream ||
      !stream.eof()) {
    refuse(value, path, "must be a number, not " + found(value));
  }
  if (!range.contains(number)) {
    refuse(value, path, value.text + " is out of range; allowed: " + range.text(), Code::kOutOfRange);
  }
  return number;
}

int read_integer(const YamlValue& value, const std::string& path, int low, int high) {
  expect_scalar(value, path, "a whole number");
  const size_t sign = !value.text.empty() && (value.text[0] == '-' || value.text[0] == '+') ? 1 : 0;
  const bool digits = value.text.size() > sign && value.text.find_first_not_of("0123456789", sign) == std::string::npos;
  if (value.quoted || !digits) refuse(value, path, "must be a whole number, not " + found(value));
  const long number = value.text.size() > 12 ? (sign && value.text[0] == '-' ? -1000000000000L : 1000000000000L)
                                             : std::stol(value.text);
  if (number < low || number > high) {
    refuse(value, path,
           value.text + " is out of range; allowed: " + std::to_string(low) + " ... " + std::to_string(high),
           Code::kOutOfRange);
  }
  return static_cast<int>(number);
}

bool read_bool(const YamlValue& value, const std::string& path) {
  expect_scalar(value, path, "true or false");
  if (!value.quoted && value.text == "true") return true;
  if (!value.quoted && value.text == "false") return false;
  refuse(value, path, "must be true or false, not " + found(value));
}

std::string read_text(const YamlValue& value, const std::string& path) {
  expect_scalar(value, path, "text");
  if (value.text.empty()) refuse(value, path, "must not be empty");
  return value.text;
}

std::string read_name(const YamlValue& value, const std::string& path) {
  const std::string name = read_text(value, path);
  const bool good = name[0] >= 'a' && name[0] <= 'z' && name.size() <= 64 &&
                    name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
  if (!good) {
    refuse(value, path,
           found(value) +
               " is not a name; allowed: lower case letters, digits and underscores, a letter "
               "first, at most 64");
  }
  return name;
}

std::string read_choice(const YamlValue& value, const std::string& path, const std::vector<std::string>& choices) {
  expect_scalar(value, path, "one of " + join(choices));
  if (std::find(choices.begin(), choices.end(), value.text) == choices.end()) {
    refuse(value, path, "unknown " + found(value) + hint(value.text, choices));
  }
  return value.text;
}

void read_vector(const YamlValue& value, const std::string& path, const Range& range, double* out, size_t count) {
  const std::string what = "a list of " + std::to_string(count) + " numbers";
  if (value.kind != YamlValue::Kind::kList) refuse(value, path, "must be " + what + ", not " + found(value));
  if (value.items.size() != count) {
    refuse(value, path, "must be " + what + ", not of " + std::to_string(value.items.size()));
  }
  for (size_t k = 0; k < count; ++k) {
    out[k] = read_number(value.items[k], path + "[" + std::to_string(k) + "]", range);
  }
}

void read_pair(const YamlValue& value, const std::string& path, const Range& range, std::array<double, 2>* out) {
  if (value.kind == YamlValue::Kind::kList) {
    read_vector(value, path, range, out->data(), out->size());
  } else {
    out->fill(read_number(value, path, range));
  }
}

const std::vector<YamlValue>& read_list(const YamlValue& value, const std::string& path, const std::string& of_what) {
  if (value.kind != YamlValue::Kind::kList) {
    refuse(value, path, "must be a list of " + of_what + ", not " + found(value));
  }
  return value.items;
}

const YamlValue& read_tagged(const YamlValue& value, const std::string& path, const std::vector<std::string>& tags) {
  if (value.kind != YamlValue::Kind::kMap || value.items.size() != 1) {
    refuse(value, path, "must be a map with one key, one of " + join(tags));
  }
  const YamlValue& entry = value.items.front();
  if (std::find(tags.begin(), tags.end(), entry.key) == tags.end()) {
    refuse_key(entry, path + "." + entry.key, "unknown key" + hint(entry.key, tags));
  }
  return entry;
}

void check_keys(const YamlValue& value, const std::string& path, const MapText& map) {
  if (value.kind != YamlValue::Kind::kMap) refuse(value, path, std::string("must be a map, not ") + found(value));
  const std::string prefix = path.empty() ? "" : path + ".";
  std::vector<std::string> known;
  for (const KeyText& key : map.keys) known.push_back(key.name);
  for (const YamlValue& item : value.items) {
    if (std::find(known.begin(), known.end(), item.key) == known.end()) {
      refuse_key(item, prefix + item.key, "unknown key" + hint(item.key, known));
    }
  }
  for (const KeyText& key : map.keys) {
    if (key.required && !value.find(key.name)) {
      refuse(value, prefix + key.name, "required, and missing" + (key.range.empty() ? "" : "; allowed: " + key.range));
    }
  }
  for (const std::vector<std::string>& group : map.at_most_one) {
    const std::vector<std::string> given = present(value, group);
    if (given.size() > 1) refuse_key(*value.find(given[1]), prefix + given[1], "excludes " + given[0] + "; give one");
  }
  if (!map.exactly_one.empty() && present(value, map.exactly_one).size() != 1) {
    refuse(value, path, "needs exactly one of " + join(map.exactly_one));
  }
}

}  // namespace deformable_sim
