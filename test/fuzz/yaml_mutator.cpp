#include "fuzz/yaml_mutator.h"

#include <cctype>
#include <random>
#include <set>

#include "../../src/scene/yaml_value.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/material_library.h"

namespace deformable_sim {
namespace fuzz {
namespace {

constexpr size_t kMostText = 200;      // of a repeated scalar
constexpr size_t kMostCopies = 40;     // of a list item
constexpr size_t kMostEmitted = 6000;  // bytes

const char* const kExtremes[] = {"0",           "-0.0",
                                 "1",           "-1",
                                 "0.5",         "2",
                                 "3",           "1e-9",
                                 "1e-30",       "5e-324",
                                 "1e308",       "-1e308",
                                 "1e309",       ".nan",
                                 ".inf",        "-.inf",
                                 "nan",         "inf",
                                 "1e6",         "1e12",
                                 "1000000000",  "4294967296",
                                 "-2147483649", "9223372036854775808",
                                 "0x7fffffff",  "1_000",
                                 "1e",          "true",
                                 "false",       "null",
                                 "~",           "\"\"",
                                 "[]",          "{}",
                                 "100",         "0.001",
                                 "1e-4",        "999999999999999999999999999999"};

class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}

  void change(const YamlValue* other, YamlValue* root) {
    std::vector<YamlValue*> values;
    collect(root, &values);
    YamlValue& at = *values[below(values.size())];
    switch (below(12)) {
      case 0:
      case 1:
      case 2:
        scalar(pick(kExtremes), &at);
        break;
      case 3:
        scale_number(&at);
        break;
      case 4:
        if (!at.items.empty()) at.items.erase(at.items.begin() + static_cast<long>(below(at.items.size())));
        break;
      case 5:
        repeat_item(&at);
        break;
      case 6:
        take_from(*values[below(values.size())], &at);
        break;
      case 7:
        if (other) take_from(random_part(*other), &at);
        break;
      case 8:
        if (!at.key.empty()) at.key = word();
        break;
      case 9:
        add_key(&at);
        break;
      case 10:
        nest(&at);
        break;
      default:
        scalar(word(), &at);
    }
  }

  std::string emit(const YamlValue& value) {
    std::string text;
    emit(value, &text);
    return text + "\n";
  }

 private:
  size_t below(size_t n) { return n == 0 ? 0 : std::uniform_int_distribution<size_t>(0, n - 1)(random_); }
  template <size_t N>
  std::string pick(const char* const (&words)[N]) {
    return words[below(N)];
  }
  std::string word() {
    static const std::vector<std::string> kWords = known_words();
    return kWords[below(kWords.size())];
  }

  void collect(YamlValue* value, std::vector<YamlValue*>* out) {
    out->push_back(value);
    for (YamlValue& item : value->items) collect(&item, out);
  }
  YamlValue random_part(YamlValue whole) {
    std::vector<YamlValue*> values;
    collect(&whole, &values);
    return *values[below(values.size())];
  }

  /// `text` stands as it is: extremes are lists and maps too.
  static void scalar(const std::string& text, YamlValue* at) {
    at->kind = YamlValue::Kind::kScalar;
    at->text = text;
    at->quoted = false;
    at->items.clear();
  }
  void scale_number(YamlValue* at) {
    if (at->kind != YamlValue::Kind::kScalar) return;
    static const char* const kTails[] = {"e1", "e2", "e-1", "e-2", "e3", "e-3", "e6", "e-6", "0", "00", "5"};
    at->text = below(4) == 0 ? "-" + at->text : at->text + pick(kTails);
  }
  void repeat_item(YamlValue* at) {
    if (at->items.empty()) {
      if (at->kind == YamlValue::Kind::kScalar && at->text.size() < kMostText) at->text += at->text;
      return;
    }
    const YamlValue item = at->items[below(at->items.size())];
    const size_t copies = below(8) == 0 ? kMostCopies : 1;
    at->items.insert(at->items.end(), copies, item);
  }
  static void take_from(YamlValue from, YamlValue* at) {
    from.key = at->key;
    *at = std::move(from);
  }
  void add_key(YamlValue* at) {
    if (at->kind != YamlValue::Kind::kMap) return;
    YamlValue item;
    scalar(below(2) == 0 ? pick(kExtremes) : word(), &item);
    item.key = word();
    at->items.push_back(std::move(item));
  }
  void nest(YamlValue* at) {
    const size_t levels = below(6) == 0 ? 40 : 1;
    for (size_t k = 0; k < levels; ++k) {
      YamlValue outer;
      outer.kind = below(2) == 0 ? YamlValue::Kind::kList : YamlValue::Kind::kMap;
      outer.key = at->key;
      at->key = outer.kind == YamlValue::Kind::kMap ? word() : "";
      outer.items.push_back(std::move(*at));
      *at = std::move(outer);
    }
  }

  static void emit_text(const std::string& text, bool quoted, std::string* out) {
    bool plain = !quoted && !text.empty();
    for (const char c : text) {
      plain = plain &&
              (std::isalnum(static_cast<unsigned char>(c)) || std::string("_.+-/[]{}~\"").find(c) != std::string::npos);
    }
    if (plain) {
      *out += text;
      return;
    }
    *out += '"';
    for (const char c : text) {
      if (c == '"' || c == '\\') *out += '\\';
      *out += c;
    }
    *out += '"';
  }
  void emit(const YamlValue& value, std::string* out) {
    if (out->size() > kMostEmitted) {
      *out += '0';
      return;
    }
    // Some values get an anchor, and some are aliases of the one before.
    if (below(200) == 0) *out += "&a ";
    if (below(400) == 0) {
      *out += "*a ";
      return;
    }
    const bool map = value.kind == YamlValue::Kind::kMap;
    if (!map && value.kind != YamlValue::Kind::kList) {
      emit_text(value.kind == YamlValue::Kind::kNull ? "~" : value.text, value.quoted, out);
      return;
    }
    *out += map ? "{" : "[";
    for (const YamlValue& item : value.items) {
      if (map) {
        emit_text(item.key, false, out);
        *out += ": ";
      }
      emit(item, out);
      *out += ",\n ";
    }
    *out += map ? "}" : "]";
  }

  std::mt19937 random_;
};

bool parse(const std::string& text, YamlValue* root) {
  try {
    *root = parse_yaml(text, "");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::string mutate_yaml(const std::string& text, const std::string& other, std::uint32_t seed) {
  YamlValue root, from;
  if (!parse(text, &root)) return text;
  const bool has_other = parse(other, &from);
  Mutator mutator(seed);
  for (std::uint32_t k = 0; k <= seed % 4; ++k) mutator.change(has_other ? &from : nullptr, &root);
  return mutator.emit(root);
}

std::vector<std::string> known_words() {
  // The reference page has every key and choice in its tables; its prose does no harm.
  std::set<std::string> words;
  std::string word;
  for (const char c : scene_reference() + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
      word += c;
      continue;
    }
    if (word.size() > 1 && word.size() < 30 && std::islower(static_cast<unsigned char>(word[0]))) words.insert(word);
    word.clear();
  }
  for (const std::string& name : load_material_library(default_material_dir()).names()) words.insert(name);
  return {words.begin(), words.end()};
}

}  // namespace fuzz
}  // namespace deformable_sim
