// Springs as a term of the equations of motion.
#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {

std::unique_ptr<Energy> make_springs(const std::string& name, const std::vector<SpringLink>& links, int first_node) {
  std::vector<ElementEnergy<Spring>::Element> elements;
  elements.reserve(links.size());
  for (const SpringLink& link : links) {
    elements.push_back({{link.a + first_node, link.b + first_node}, {link.rest_length, link.stiffness, link.damping}});
  }
  return std::make_unique<ElementEnergy<Spring>>(name, std::move(elements), Spring::Parameters{});
}

}  // namespace deformable_sim
