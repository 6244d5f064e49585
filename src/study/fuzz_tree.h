// A scene file as a tree of maps, lists and scalars, to be made, cut down and written as YAML text.
#pragma once

#include <array>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

namespace deformable_sim::fuzz {

struct Tree {
  enum class Kind { kScalar, kList, kMap };
  Kind kind = Kind::kMap;
  std::string text;                                 // of a scalar
  std::vector<std::pair<std::string, Tree>> items;  // of a map in the order of writing; of a list, keys are empty

  Tree() = default;
  Tree(const std::string& scalar) : kind(Kind::kScalar), text(scalar) {}
  Tree(const char* scalar) : Tree(std::string(scalar)) {}
  /// Numbers are written with four digits: what is simulated is what is written.
  Tree(double number);
  Tree(int number) : Tree(std::to_string(number)) {}
  template <std::size_t N>
  Tree(const std::array<double, N>& numbers) : kind(Kind::kList) {
    for (const double number : numbers) push(number);
  }

  static Tree list() {
    Tree tree;
    tree.kind = Kind::kList;
    return tree;
  }

  bool empty() const { return items.empty(); }
  void push(Tree item) { items.emplace_back("", std::move(item)); }
  /// Null when a map has no such key.
  const Tree* find(const std::string& key) const;
  /// The item of that key, made (as a map) when there is none.
  Tree& operator[](const std::string& key);
  void erase(const std::string& key);
};

/// One line a key of the top map, one line an item of its lists, all below in flow style.
std::string yaml_of(const Tree& tree);

/// A number as the trees write it.
std::string number_text(double number);

}  // namespace deformable_sim::fuzz
