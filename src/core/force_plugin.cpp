#include "deformable_sim/core/force_plugin.h"

#include <algorithm>

#include "deformable_sim/core/error.h"

namespace deformable_sim {

double ForceRequest::number(const std::string& key, double standard) const {
  const auto found = parameters.find(key);
  if (found == parameters.end()) return standard;
  if (found->second.size() != 1) throw InputError("parameters." + key + ": must be one number");
  return found->second[0];
}

Vec3 ForceRequest::vector(const std::string& key) const {
  const auto found = parameters.find(key);
  if (found == parameters.end() || found->second.size() != 3) {
    throw InputError("parameters." + key + ": must be given as [x, y, z]");
  }
  return {found->second[0], found->second[1], found->second[2]};
}

void ForceRequest::check_keys(const std::vector<std::string>& known) const {
  for (const auto& parameter : parameters) {
    if (std::find(known.begin(), known.end(), parameter.first) != known.end()) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    throw InputError("parameters." + parameter.first + ": no such parameter; there is " + names);
  }
}

}  // namespace deformable_sim
