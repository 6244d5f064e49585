// Changes a YAML text as a tree, so that most of what comes out is a scene again, and not quite.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace deformable_sim {
namespace fuzz {

/// One to four changes drawn from `seed`: extreme numbers, values of another kind, keys of the schema in the wrong
/// place, parts left out, repeated, exchanged, nested deep, anchors with aliases. `other` gives parts too. Text that is
/// no YAML is returned as it is.
std::string mutate_yaml(const std::string& text, const std::string& other, std::uint32_t seed);

/// All keys of scenes and materials, and the words that they may have.
std::vector<std::string> known_words();

}  // namespace fuzz
}  // namespace deformable_sim
