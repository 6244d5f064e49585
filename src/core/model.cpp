#include "deformable_sim/core/model.h"

namespace deformable_sim {

int Model::find_body(const std::string& name) const {
  for (size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].name == name) return static_cast<int>(i);
  return -1;
}

}  // namespace deformable_sim
