// Scenes made at random: files that a user could have written, and commands from outside.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "fuzz_tree.h"

namespace deformable_sim::fuzz {

struct Case {
  Tree scene;
  std::vector<std::string> commands;  // lines of fuzz_commands.h
};

/// The same seed gives the same case. One to three bodies of every kind and model, some 500 nodes at most; materials by
/// name or over six decades; colliders of every shape, grasps of every kind, a script, commands between steps; solvers
/// chosen or named with their keys. Some percent of the scenes are refused by the loader: keys are drawn one by one,
/// and not every combination has a meaning.
Case make_case(std::uint64_t seed);

/// The file.
std::string text_of(const Case& c);

/// Meshes that the scenes name, as (path relative to the scene, text): sheets with uneven triangles and slivers,
/// tetrahedra, closed surfaces.
std::vector<std::pair<std::string, std::string>> meshes();
/// Writes them beside scenes in `dir`. Throws InputError.
void write_meshes(const std::string& dir);

}  // namespace deformable_sim::fuzz
