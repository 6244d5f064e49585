#include "yaml_value.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

namespace deformable_sim {
namespace {

constexpr int kMaxOpenBrackets = 1000;

int line_of(const YAML::Mark& mark) {
  return mark.line + 1;
}

std::string place(const std::string& origin, int line) {
  return line > 0 ? origin + ":" + std::to_string(line) : origin;
}

/// Length of the well-formed UTF-8 sequence at text[i], or 0.
size_t sequence_length(const std::string& text, size_t i) {
  const unsigned char first = static_cast<unsigned char>(text[i]);
  const size_t length = first < 0x80                    ? 1
                        : first >= 0xc2 && first < 0xe0 ? 2
                        : first >= 0xe0 && first < 0xf0 ? 3
                        : first >= 0xf0 && first < 0xf5 ? 4
                                                        : 0;
  if (length == 0 || i + length > text.size()) return 0;
  for (size_t k = 1; k < length; ++k) {
    if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return 0;
  }
  return length;
}

/// A message quotes what the user wrote: one line of valid UTF-8, which clients in other languages insist on.
InputError error_of(const std::string& message, Code code = Code::kInvalidArgument) {
  std::string clean;
  for (size_t i = 0; i < message.size();) {
    const size_t length = sequence_length(message, i);
    const bool control = length == 1 && (static_cast<unsigned char>(message[i]) < 0x20 || message[i] == 0x7f);
    clean += control ? " " : length == 0 ? "?" : message.substr(i, length);
    i += std::max<size_t>(1, length);
  }
  return InputError(clean, code);
}

/// What a value costs in memory, in values of ordinary length: copies of one long text count too.
int weight_of(const YamlValue& value) {
  int n = 1 + static_cast<int>((value.text.size() + value.key.size()) / 64);
  for (const YamlValue& item : value.items) n += weight_of(item);
  return n;
}

void relocate(const std::string& origin, YamlValue* value) {
  value->origin = origin;
  value->line = value->key_line = 0;
  for (YamlValue& item : value->items) relocate(origin, &item);
}

/// Builds the tree from parser events: unlike YAML::Node, events show duplicate keys and never share or expand aliases
/// behind our back.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string origin) : origin_(std::move(origin)) {}

  YamlValue take_root() { return std::move(root_); }
  int first_line() const { return first_line_; }

  void OnDocumentStart(const YAML::Mark& mark) override { first_line_ = line_of(mark); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    add(make(YamlValue::Kind::kNull, mark), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) fail(mark, "an alias inside the value it stands for");
    count(weight_of(found->second), mark);
    YamlValue copy = found->second;
    copy.line = line_of(mark);
    add(std::move(copy), 0);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    YamlValue value = make(YamlValue::Kind::kScalar, mark);
    value.text = text;
    value.quoted = tag == "!";
    add(std::move(value), anchor);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(make(YamlValue::Kind::kList, mark), anchor, mark);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(make(YamlValue::Kind::kMap, mark), anchor, mark);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlValue value;
    YAML::anchor_t anchor = 0;
    bool has_key = false;
    std::string key;
    int key_line = 0;
    std::map<std::string, int> key_lines;
  };

  [[noreturn]] void fail(const YAML::Mark& mark, const std::string& what) const {
    throw error_of(place(origin_, line_of(mark)) + ": " + what);
  }
  void count(int n, const YAML::Mark& mark) {
    values_ += n;
    if (values_ > kMaxYamlValues) {
      fail(mark, "more than " + std::to_string(kMaxYamlValues) + " values once aliases are expanded");
    }
  }
  YamlValue make(YamlValue::Kind kind, const YAML::Mark& mark) {
    count(1, mark);
    YamlValue value;
    value.kind = kind;
    value.origin = origin_;
    value.line = line_of(mark);
    return value;
  }
  void open(YamlValue value, YAML::anchor_t anchor, const YAML::Mark& mark) {
    if (static_cast<int>(open_.size()) >= kMaxYamlDepth) {
      fail(mark, "nested deeper than " + std::to_string(kMaxYamlDepth) + " levels");
    }
    Open level;
    level.value = std::move(value);
    level.anchor = anchor;
    open_.push_back(std::move(level));
  }
  void close() {
    Open level = std::move(open_.back());
    open_.pop_back();
    add(std::move(level.value), level.anchor);
  }
  void add(YamlValue value, YAML::anchor_t anchor) {
    if (anchor != 0) {
      values_ += weight_of(value);
      anchors_[anchor] = value;
    }
    if (open_.empty()) {
      root_ = std::move(value);
      return;
    }
    Open& level = open_.back();
    if (level.value.kind == YamlValue::Kind::kList) {
      level.value.items.push_back(std::move(value));
    } else if (!level.has_key) {
      take_key(value, &level);
    } else {
      value.key = level.key;
      value.key_line = level.key_line;
      // The parser marks an empty value at whatever token follows; its key is where a reader looks.
      if (value.kind == YamlValue::Kind::kNull) value.line = level.key_line;
      level.has_key = false;
      level.value.items.push_back(std::move(value));
    }
  }
  void take_key(const YamlValue& key, Open* level) const {
    if (key.kind != YamlValue::Kind::kScalar) {
      throw error_of(place(origin_, key.line) + ": a key must be a plain word");
    }
    const auto added = level->key_lines.emplace(key.text, key.line);
    if (!added.second) {
      throw error_of(place(origin_, key.line) + ": " + key.text + ": given twice; the first is at line " +
                     std::to_string(added.first->second));
    }
    level->has_key = true;
    level->key = key.text;
    level->key_line = key.line;
  }

  std::string origin_;
  int first_line_ = 1;
  int values_ = 0;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, YamlValue> anchors_;
  YamlValue root_;
};

void emit(const YamlValue& value, YAML::Emitter* out) {
  switch (value.kind) {
    case YamlValue::Kind::kNull:
      *out << YAML::Null;
      return;
    case YamlValue::Kind::kScalar:
      if (value.quoted) *out << YAML::DoubleQuoted;
      *out << value.text;
      return;
    case YamlValue::Kind::kList:
      *out << YAML::Flow << YAML::BeginSeq;
      for (const YamlValue& item : value.items) emit(item, out);
      *out << YAML::EndSeq;
      return;
    case YamlValue::Kind::kMap:
      *out << YAML::Flow << YAML::BeginMap;
      for (const YamlValue& item : value.items) {
        *out << YAML::Key << item.key << YAML::Value;
        emit(item, out);
      }
      *out << YAML::EndMap;
      return;
  }
}

/// The parser keeps a mark for each open bracket before it tells of the first: a text of nothing else would take a
/// hundred times its size. Brackets within quotes and comments count too, of which no scene has so many unbalanced.
void check_brackets(const std::string& text, const std::string& origin) {
  int open = 0, line = 1;
  for (const char c : text) {
    line += c == '\n';
    open += c == '[' || c == '{';
    open -= c == ']' || c == '}';
    if (open > kMaxOpenBrackets) {
      throw error_of(place(origin, line) + ": nested deeper than " + std::to_string(kMaxYamlDepth) + " levels");
    }
  }
}

/// One step of an override path: a key, or a list index when `key` is empty.
struct PathStep {
  std::string key;
  size_t index = 0;
};

std::vector<PathStep> split_path(const std::string& path) {
  const std::string hint = "; a path looks like bodies[0].cloth.cells";
  std::vector<PathStep> steps;
  size_t i = 0;
  bool expect_key = true;
  while (i < path.size()) {
    PathStep step;
    if (path[i] == '[') {
      const size_t end = path.find(']', i);
      const std::string digits = end == std::string::npos ? "" : path.substr(i + 1, end - i - 1);
      const bool number =
          !digits.empty() && digits.size() < 7 && digits.find_first_not_of("0123456789") == std::string::npos;
      if (expect_key || !number) throw error_of("--set " + path + ": malformed path" + hint);
      step.index = static_cast<size_t>(std::stoul(digits));
      i = end + 1;
    } else {
      if (!expect_key && path[i] != '.') throw error_of("--set " + path + ": malformed path" + hint);
      if (!expect_key) ++i;
      const size_t end = std::min(path.find_first_of(".[", i), path.size());
      step.key = path.substr(i, end - i);
      if (step.key.empty()) throw error_of("--set " + path + ": malformed path" + hint);
      i = end;
    }
    expect_key = false;
    steps.push_back(step);
  }
  if (steps.empty() || path.back() == '.') throw error_of("--set " + path + ": malformed path" + hint);
  return steps;
}

YamlValue* descend(const PathStep& step, const std::string& path, YamlValue* at) {
  if (step.key.empty()) {
    if (at->kind != YamlValue::Kind::kList) throw error_of("--set " + path + ": [...] after something that is no list");
    if (step.index >= at->items.size()) {
      throw error_of("--set " + path + ": index " + std::to_string(step.index) + " of a list of " +
                         std::to_string(at->items.size()),
                     Code::kOutOfRange);
    }
    return &at->items[step.index];
  }
  if (at->kind == YamlValue::Kind::kNull) at->kind = YamlValue::Kind::kMap;
  if (at->kind != YamlValue::Kind::kMap) {
    throw error_of("--set " + path + ": '" + step.key + "' is looked for in something that is no map");
  }
  for (YamlValue& item : at->items) {
    if (item.key == step.key) return &item;
  }
  YamlValue made;
  made.origin = "--set " + path;
  made.key = step.key;
  at->items.push_back(std::move(made));
  return &at->items.back();
}

}  // namespace

const YamlValue* YamlValue::find(const std::string& name) const {
  for (const YamlValue& item : items) {
    if (item.key == name) return &item;
  }
  return nullptr;
}

std::string YamlValue::where() const {
  return place(origin, line);
}

YamlValue parse_yaml(const std::string& text, const std::string& origin) {
  if (text.size() > kMaxSceneBytes) {
    throw error_of(origin + ": larger than " + std::to_string(kMaxSceneBytes >> 20) + " MiB");
  }
  check_brackets(text, origin);
  TreeBuilder tree(origin);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(tree)) return YamlValue{};
    TreeBuilder second(origin);
    if (parser.HandleNextDocument(second)) {
      throw error_of(place(origin, second.first_line()) + ": a second document; a scene is one");
    }
  } catch (const YAML::Exception& error) {
    const int line = error.mark.is_null() ? 1 : line_of(error.mark);
    throw error_of(place(origin, line) + ": not valid YAML: " + error.msg);
  }
  return tree.take_root();
}

std::string yaml_text(const YamlValue& value) {
  YAML::Emitter out;
  emit(value, &out);
  return out.c_str();
}

void override_value(const std::string& path, const std::string& value, YamlValue* root) {
  YamlValue* at = root;
  for (const PathStep& step : split_path(path)) at = descend(step, path, at);
  YamlValue parsed;
  try {
    parsed = parse_yaml(value, "VALUE");
  } catch (const InputError& error) {
    throw error_of("--set " + path + ": '" + value + "': " + error.what(), error.code());
  }
  relocate("--set " + path, &parsed);
  parsed.key = at->key;
  *at = std::move(parsed);
}

void refuse(const YamlValue& value, const std::string& full_path, const std::string& what, Code code) {
  // Keys come from the user: keep the message one line of readable length.
  const std::string path = full_path.size() > 120 ? full_path.substr(0, 117) + "..." : full_path;
  const std::string where = value.where();
  const bool said = path.empty() || where == "--set " + path;
  throw error_of(where + ": " + (said ? "" : path + ": ") + what, code);
}

void refuse_key(const YamlValue& value, const std::string& path, const std::string& what) {
  YamlValue at;
  at.origin = value.origin;
  at.line = value.key_line;
  refuse(at, path, what);
}

}  // namespace deformable_sim
