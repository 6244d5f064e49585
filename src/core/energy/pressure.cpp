// Gauge pressure inside a closed surface as a term of the equations of motion.
#include "deformable_sim/core/element/enclosed_pressure.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {

std::unique_ptr<Energy> make_pressure(const std::vector<std::array<int, 3>>& triangles, double pressure, double rise,
                                      int first_node) {
  std::vector<ElementEnergy<EnclosedPressure>::Element> elements;
  elements.reserve(triangles.size());
  for (const auto& t : triangles) elements.push_back({{t[0] + first_node, t[1] + first_node, t[2] + first_node}, {}});
  return std::make_unique<ElementEnergy<EnclosedPressure>>("pressure", std::move(elements),
                                                           EnclosedPressure::Parameters{pressure, rise});
}

}  // namespace deformable_sim
