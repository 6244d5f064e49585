// `study work_precision`: the command line.
#pragma once

#include <string>
#include <vector>

namespace deformable_sim::work_precision {

extern const char kUsage[];

/// `words` follow "work_precision". Throws InputError; returns the exit code.
int command(const std::vector<std::string>& words);

}  // namespace deformable_sim::work_precision
