// Tables of keys: one description of every map of a scene, which the loader reads with and the reference page prints.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/core/types.h"
#include "yaml_value.h"

namespace deformable_sim {

/// Allowed values of a number: low ... high, or above low when `open`.
struct Range {
  double low;
  double high;
  bool open = false;

  bool contains(double value) const { return (open ? value > low : value >= low) && value <= high; }
  std::string text() const;
};
inline Range between(double low, double high) {
  return {low, high, false};
}
inline Range above(double low, double high) {
  return {low, high, true};
}

/// What the reference page says of a key.
struct KeyText {
  std::string name, type, unit, standard, range, doc;
  bool required = false;
};

/// What the reference page says of a map.
struct MapText {
  std::string path;
  std::string doc;
  std::vector<KeyText> keys;
  std::vector<std::vector<std::string>> at_most_one;  // keys that exclude each other
  std::vector<std::string> exactly_one;
};

std::string format_number(double value);
std::string format_vector(const double* values, size_t count);

// Readers of single values. All throw InputError naming place, path and what is allowed.
double read_number(const YamlValue& value, const std::string& path, const Range& range);
int read_integer(const YamlValue& value, const std::string& path, int low, int high);
bool read_bool(const YamlValue& value, const std::string& path);
std::string read_text(const YamlValue& value, const std::string& path);
/// Lower case letters, digits and underscores, a letter first: it becomes part of a topic name.
std::string read_name(const YamlValue& value, const std::string& path);
std::string read_choice(const YamlValue& value, const std::string& path, const std::vector<std::string>& choices);
void read_vector(const YamlValue& value, const std::string& path, const Range& range, double* out, size_t count);
/// A list of two numbers, or one number that stands for both.
void read_pair(const YamlValue& value, const std::string& path, const Range& range, std::array<double, 2>* out);
/// The items of a list; refuses anything else.
const std::vector<YamlValue>& read_list(const YamlValue& value, const std::string& path, const std::string& of_what);
/// The one entry of a single-key map such as `cloth: {...}`; refuses other keys.
const YamlValue& read_tagged(const YamlValue& value, const std::string& path, const std::vector<std::string>& tags);

/// Refuses what is no map, unknown keys (naming the nearest known), missing and mutually exclusive keys.
void check_keys(const YamlValue& value, const std::string& path, const MapText& map);

/// At most `count` of the words that contain `word`, or that a slip of the pen may have meant; the likeliest first.
std::vector<std::string> nearest_words(const std::string& word, const std::vector<std::string>& words, size_t count);

std::string join(const std::vector<std::string>& words, const std::string& separator = ", ");

/// The keys of one map and where each goes in T. `get` is a member pointer or a function from T& to the field.
template <class T>
class Table {
 public:
  using Reader = std::function<void(const YamlValue&, const std::string& path, T*)>;

  Table(std::string path, std::string doc) {
    map_.path = std::move(path);
    map_.doc = std::move(doc);
  }

  template <class Get>
  Table& number(const std::string& name, const std::string& unit, Get get, Range range, const std::string& doc) {
    const auto prototype = std::make_unique<T>();
    const KeyText text{name, "number", unit, format_number(std::invoke(get, *prototype)), range.text(), doc};
    return add(text, [get, range](const YamlValue& v, const std::string& path, T* out) {
      std::invoke(get, *out) = read_number(v, path, range);
    });
  }
  /// A std::optional<double>; `standard` says what holds when it is absent.
  template <class Get>
  Table& optional_number(const std::string& name, const std::string& unit, Get get, Range range,
                         const std::string& standard, const std::string& doc) {
    return add({name, "number", unit, standard, range.text(), doc},
               [get, range](const YamlValue& v, const std::string& path, T* out) {
                 std::invoke(get, *out) = read_number(v, path, range);
               });
  }
  template <class Get>
  Table& integer(const std::string& name, Get get, int low, int high, const std::string& doc) {
    const auto prototype = std::make_unique<T>();
    const std::string range = std::to_string(low) + " ... " + std::to_string(high);
    return add({name, "integer", "", std::to_string(std::invoke(get, *prototype)), range, doc},
               [get, low, high](const YamlValue& v, const std::string& path, T* out) {
                 std::invoke(get, *out) = read_integer(v, path, low, high);
               });
  }
  template <class Get>
  Table& boolean(const std::string& name, Get get, const std::string& doc) {
    const auto prototype = std::make_unique<T>();
    return add(
        {name, "bool", "", std::invoke(get, *prototype) ? "true" : "false", "true, false", doc},
        [get](const YamlValue& v, const std::string& path, T* out) { std::invoke(get, *out) = read_bool(v, path); });
  }
  template <class Get>
  Table& text(const std::string& name, Get get, const std::string& doc) {
    return add({name, "text", "", "", "", doc}, [get](const YamlValue& v, const std::string& path, T* out) {
      std::invoke(get, *out) = read_text(v, path);
    });
  }
  template <class Get>
  Table& name(const std::string& name, Get get, const std::string& doc) {
    add({name, "name", "", "", "a-z, 0-9, _", doc},
        [get](const YamlValue& v, const std::string& path, T* out) { std::invoke(get, *out) = read_name(v, path); });
    return required();
  }
  template <class Get>
  Table& choice(const std::string& name, Get get, const std::vector<std::string>& choices, const std::string& doc) {
    const auto prototype = std::make_unique<T>();
    return add({name, "word", "", std::invoke(get, *prototype), join(choices), doc},
               [get, choices](const YamlValue& v, const std::string& path, T* out) {
                 std::invoke(get, *out) = read_choice(v, path, choices);
               });
  }
  /// A Vec3 or std::array of doubles; the range holds for each component.
  template <class Get>
  Table& vector(const std::string& name, const std::string& form, const std::string& unit, Get get, Range range,
                const std::string& doc) {
    const auto prototype = std::make_unique<T>();
    const auto& standard = std::invoke(get, *prototype);
    const size_t count = static_cast<size_t>(standard.size());
    return add({name, form, unit, format_vector(standard.data(), count), range.text(), doc},
               [get, range, count](const YamlValue& v, const std::string& path, T* out) {
                 read_vector(v, path, range, std::invoke(get, *out).data(), count);
               });
  }
  /// A std::array of two doubles, or an optional one, given as a list or as one number for both; `standard` says what
  /// holds when it is absent.
  template <class Get>
  Table& pair(const std::string& name, const std::string& form, const std::string& unit, Get get, Range range,
              const std::string& standard, const std::string& doc) {
    return add({name, "number or " + form, unit, standard, range.text(), doc},
               [get, range](const YamlValue& v, const std::string& path, T* out) {
                 std::array<double, 2> both{};
                 read_pair(v, path, range, &both);
                 std::invoke(get, *out) = both;
               });
  }
  /// A map inside this one, read with its own table.
  template <class Get, class Sub>
  Table& map(const std::string& name, Get get, const Table<Sub>& table, const std::string& doc) {
    return add({name, "map", "", "", "", doc}, [get, table](const YamlValue& v, const std::string& path, T* out) {
      table.read(v, path, &std::invoke(get, *out));
    });
  }
  Table& add(KeyText text, Reader read) {
    map_.keys.push_back(std::move(text));
    readers_.push_back(std::move(read));
    return *this;
  }
  /// Makes the key added last a required one.
  Table& required() {
    map_.keys.back().required = true;
    return *this;
  }
  Table& at_most_one_of(std::vector<std::string> names) {
    map_.at_most_one.push_back(std::move(names));
    return *this;
  }
  Table& exactly_one_of(std::vector<std::string> names) {
    map_.exactly_one = std::move(names);
    return *this;
  }

  /// Reads every key that stands in `value` into `out`, in the order of the table.
  void read(const YamlValue& value, const std::string& path, T* out) const {
    check_keys(value, path, map_);
    for (size_t k = 0; k < readers_.size(); ++k) {
      const YamlValue* item = value.find(map_.keys[k].name);
      if (item) readers_[k](*item, path.empty() ? item->key : path + "." + item->key, out);
    }
  }
  /// Reads one value, which stands under `path`, as that of its key.
  void read_key(const YamlValue& value, const std::string& path, T* out) const {
    for (size_t k = 0; k < readers_.size(); ++k) {
      if (map_.keys[k].name == value.key) readers_[k](value, path, out);
    }
  }
  const MapText& text() const { return map_; }

 private:
  MapText map_;
  std::vector<Reader> readers_;
};

}  // namespace deformable_sim
