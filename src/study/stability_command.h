// `study stability`: what is asked for, and what is written.
#pragma once

#include <string>
#include <vector>

namespace deformable_sim::stability {

extern const char kUsage[];

/// 0 done. Throws InputError where the arguments are refused.
int command(const std::vector<std::string>& words);

}  // namespace deformable_sim::stability
