// A scene text as a tree that knows where each value stands. The only file pair, besides its tests, that sees yaml-cpp.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

/// One YAML value with its place. Maps keep the order of the file; keys are unique.
struct YamlValue {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  std::string text;              // of a scalar
  bool quoted = false;           // a scalar in quotes is text, never a number
  std::vector<YamlValue> items;  // of a list or a map
  std::string key;               // under which the value stands in its map
  int key_line = 0;              // 1-based
  std::string origin;            // file, or "--set PATH"
  int line = 0;                  // 1-based; 0: not in a file

  const YamlValue* find(const std::string& name) const;
  /// "file:line" or "--set PATH".
  std::string where() const;
};

/// Bounds on what is read, so that no text can hang or exhaust the process.
constexpr size_t kMaxSceneBytes = 4u << 20;
constexpr int kMaxYamlDepth = 32;
constexpr int kMaxYamlValues = 500000;  // after aliases are expanded

/// Throws InputError: "origin:line: what". One document; no duplicate keys; scalar keys; aliases are copied.
YamlValue parse_yaml(const std::string& text, const std::string& origin);

/// A text from which parse_yaml() reads the same values and keys.
std::string yaml_text(const YamlValue& value);

/// Sets the value at `path` ("bodies[0].cloth.cells") to the YAML text `value`. Missing maps on the way are made; a
/// list index must exist. Throws InputError: "--set PATH: what".
void override_value(const std::string& path, const std::string& value, YamlValue* root);

/// "file:line: path: what", or "--set PATH: what" for a value from an override.
[[noreturn]] void refuse(const YamlValue& value, const std::string& path, const std::string& what,
                         Code code = Code::kInvalidArgument);
/// The same, at the line of the value's key.
[[noreturn]] void refuse_key(const YamlValue& value, const std::string& path, const std::string& what);

}  // namespace deformable_sim
