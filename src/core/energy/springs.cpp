// Springs as a term of the equations of motion.
#include <array>
#include <utility>

#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/linear/block_kernels.h"

namespace deformable_sim {
namespace {

/// Its projected Jacobian, which implicit steps ask for, by a kernel.
class Springs : public ElementEnergy<Spring> {
 public:
  Springs(const std::string& name, std::vector<Element> elements)
      : ElementEnergy<Spring>(name, std::move(elements), {}), kernels_(block_kernels(simd_level())) {}

  void bind(const BlockMatrix& matrix) override {
    ElementEnergy<Spring>::bind(matrix);
    springs_.clear();
    for (const Element& e : elements()) {
      springs_.push_back({e.node[0], e.node[1], e.rest.length, e.rest.stiffness, e.rest.damping});
    }
  }

  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override {
    if (kind != Jacobian::kProjected || springs_.empty()) {
      ElementEnergy<Spring>::add_jacobian(s, dx, dv, kind, a);
      return;
    }
    kernels_.add_springs(element_count(), springs_.data(), slots().front().data(), s.x.data(), dx, dv,
                         a->block(0).data());
  }

 private:
  const BlockKernels& kernels_;
  std::vector<SpringElement> springs_;
};

}  // namespace

std::unique_ptr<Energy> make_springs(const std::string& name, const std::vector<SpringLink>& links, int first_node) {
  std::vector<Springs::Element> elements;
  elements.reserve(links.size());
  for (const SpringLink& link : links) {
    elements.push_back({{link.a + first_node, link.b + first_node}, {link.rest_length, link.stiffness, link.damping}});
  }
  return std::make_unique<Springs>(name, std::move(elements));
}

}  // namespace deformable_sim
