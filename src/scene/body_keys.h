// What the tables of cloth, rope and soft bodies share.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "keys.h"

namespace deformable_sim {

/// Words of a choice and what each stands for.
template <class Value>
using Choices = std::vector<std::pair<std::string, Value>>;

template <class Value>
std::vector<std::string> words_of(const Choices<Value>& choices) {
  std::vector<std::string> words;
  for (const auto& choice : choices) words.push_back(choice.first);
  return words;
}

template <class Value>
Value read_one_of(const YamlValue& v, const std::string& path, const Choices<Value>& choices) {
  const std::string word = read_choice(v, path, words_of(choices));
  for (const auto& choice : choices) {
    if (choice.first == word) return choice.second;
  }
  return choices.front().second;
}

/// A key whose words stand for values; `standard` is what the page gives as the default.
template <class T, class Get, class Value>
void add_choice(Table<T>* table, const std::string& name, Get get, const Choices<Value>& choices,
                const std::string& standard, const std::string& doc) {
  table->add({name, "word", "", standard, join(words_of(choices)), doc},
             [get, choices](const YamlValue& v, const std::string& path, T* out) {
               std::invoke(get, *out) = read_one_of(v, path, choices);
             });
}

/// Keys that come first, and last, in the table of every body.
void add_first_keys(Table<BodySpec>* table);
void add_common_keys(Table<BodySpec>* table, const std::string& contact_radius);
void add_contact_points(Table<BodySpec>* table);
/// `visual`, of cloth or soft bodies.
void add_visual_key(Table<BodySpec>* table, BodyKind kind);
/// `look`, of cloth or ropes.
void add_look_key(Table<BodySpec>* table, BodyKind kind);

/// `from: NAME` of a material map, or the whole value when it is a name alone: reads the name, applies the entry.
/// `apply(name, out)` throws InputError, which is refused at the name.
template <class T, class Apply>
void add_from(Table<T>* table, const std::string& page, Apply apply) {
  table->add({"from", "text", "", "", "doc/materials.md, " + page,
              "Starts from this entry of the tables of real materials; other keys replace what it gives."},
             [apply](const YamlValue& v, const std::string& path, T* out) {
               const std::string name = read_text(v, path);
               try {
                 apply(name, out);
               } catch (const InputError& error) {
                 refuse(v, path, error.what(), error.code());
               }
             });
}

/// A material: a map read with `table`, or the name of an entry alone, which is the same as {from: NAME}.
template <class T>
void read_material(const YamlValue& v, const std::string& path, const Table<T>& table, T* out) {
  if (v.kind != YamlValue::Kind::kScalar) {
    table.read(v, path, out);
    return;
  }
  YamlValue from = v;
  from.key = "from";
  table.read_key(from, path, out);
}

}  // namespace deformable_sim
