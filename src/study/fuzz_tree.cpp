#include "fuzz_tree.h"

#include <algorithm>
#include <cstdio>

namespace deformable_sim::fuzz {
namespace {

std::string flow(const Tree& tree) {
  if (tree.kind == Tree::Kind::kScalar) return tree.text;
  const bool map = tree.kind == Tree::Kind::kMap;
  std::string text(1, map ? '{' : '[');
  bool first = true;
  for (const auto& [key, item] : tree.items) {
    text += (first ? "" : ", ") + (map ? key + ": " : "") + flow(item);
    first = false;
  }
  return text + (map ? "}" : "]");
}

}  // namespace

std::string number_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", number);
  return text;
}

Tree::Tree(double number) : Tree(number_text(number)) {}

const Tree* Tree::find(const std::string& key) const {
  for (const auto& item : items) {
    if (item.first == key) return &item.second;
  }
  return nullptr;
}

Tree& Tree::operator[](const std::string& key) {
  for (auto& item : items) {
    if (item.first == key) return item.second;
  }
  items.emplace_back(key, Tree());
  return items.back().second;
}

void Tree::erase(const std::string& key) {
  items.erase(std::remove_if(items.begin(), items.end(), [&key](const auto& item) { return item.first == key; }),
              items.end());
}

std::string yaml_of(const Tree& tree) {
  std::string text;
  for (const auto& [key, item] : tree.items) {
    const bool lines = item.kind == Tree::Kind::kList && !item.empty() && item.items[0].second.kind == Tree::Kind::kMap;
    if (!lines) {
      text += key + ": " + flow(item) + "\n";
      continue;
    }
    text += key + ":\n";
    for (const auto& entry : item.items) {
      // `- cloth: {...}` is how people write a map of one key.
      const Tree& map = entry.second;
      const bool tagged = map.items.size() == 1;
      text += "  - " + (tagged ? map.items[0].first + ": " + flow(map.items[0].second) : flow(map)) + "\n";
    }
  }
  return text;
}

}  // namespace deformable_sim::fuzz
