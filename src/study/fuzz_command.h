// ./run study fuzz: scenes made at random, stepped and watched; what fails is cut down to a small file.
#pragma once

#include <string>
#include <vector>

namespace deformable_sim::fuzz {

extern const char kUsage[];

/// 0: no failure, 1: some. Throws InputError.
int command(const std::vector<std::string>& words);

}  // namespace deformable_sim::fuzz
