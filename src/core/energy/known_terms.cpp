#include "deformable_sim/core/energy/known_terms.h"

#include <algorithm>
#include <memory>

#include "deformable_sim/core/element/line_drag.h"
#include "deformable_sim/core/element/sheet_drag.h"
#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/quadratic_term.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/linear/constant_links.h"

namespace deformable_sim {
namespace {

using Entries = std::vector<Eigen::Triplet<double>>;

bool couples_nothing(const Energy& energy) {
  std::vector<std::array<int, 2>> pairs;
  energy.add_pattern(&pairs);
  return pairs.empty();
}

bool is_drag(const Energy& energy) {
  return dynamic_cast<const ElementEnergy<SheetDrag>*>(&energy) != nullptr ||
         dynamic_cast<const ElementEnergy<LineDrag>*>(&energy) != nullptr;
}

}  // namespace

KnownTerms sort_terms(const std::string& integrator, const std::vector<const Energy*>& energies, Eigen::Index nodes,
                      const std::vector<const Energy*>& without) {
  KnownTerms known;
  Entries stiffness, damping;
  int term = 0;
  for (const Energy* energy : energies) {
    if (std::find(without.begin(), without.end(), energy) != without.end()) continue;
    if (const MassForce* force = energy->mass_force()) {
      known.everywhere.acceleration += force->acceleration;
      known.everywhere.rate += force->rate;
    } else if (const auto* springs = dynamic_cast<const ElementEnergy<Spring>*>(energy)) {
      for (const auto& e : springs->elements()) {
        known.springs.push_back({e.node[0], e.node[1], e.rest.length, e.rest.stiffness, e.rest.damping, term});
      }
      ++term;
    } else if (const auto* quadratic = dynamic_cast<const QuadraticTerm*>(energy)) {
      quadratic->add_entries(&stiffness, &damping);
    } else if (const auto* targets = dynamic_cast<const TargetSprings*>(energy)) {
      known.targets.push_back(targets);
    } else if (is_drag(*energy) || couples_nothing(*energy)) {
      known.local.push_back(energy);
    } else {
      throw InputError("integrator " + integrator + " cannot take the term '" + energy->name() +
                           "': it knows springs, quadratic bending, and forces on single nodes; use implicit_euler or "
                           "bdf2",
                       Code::kUnavailable);
    }
  }
  if (nodes > 0 && !stiffness.empty()) {
    known.stiffness.resize(nodes, nodes);
    known.stiffness.setFromTriplets(stiffness.begin(), stiffness.end());
  }
  if (nodes > 0 && !damping.empty()) {
    known.damping.resize(nodes, nodes);
    known.damping.setFromTriplets(damping.begin(), damping.end());
  }
  return known;
}

bool stays_apart(const Energy& energy) {
  return energy.constant_links() != nullptr || dynamic_cast<const ElementEnergy<Spring>*>(&energy) != nullptr;
}

SpringTerms take_springs(std::vector<const Energy*>* terms) {
  SpringTerms taken;
  std::vector<const Energy*> rest;
  std::vector<char> sprung;
  for (const Energy* energy : *terms) {
    const auto* springs = dynamic_cast<const ElementEnergy<Spring>*>(energy);
    if (springs == nullptr) {
      rest.push_back(energy);
      continue;
    }
    for (const auto& e : springs->elements()) {
      taken.springs.push_back({e.node[0], e.node[1], e.rest.length, e.rest.stiffness, e.rest.damping, 0});
      sprung.resize(std::max<size_t>(sprung.size(), static_cast<size_t>(std::max(e.node[0], e.node[1])) + 1), 0);
      for (int node : e.node) sprung[static_cast<size_t>(node)] = 1;
    }
  }
  const auto fits = [&](const Energy* energy) {
    if (dynamic_cast<const QuadraticTerm*>(energy) == nullptr || energy->constant_links() == nullptr) return false;
    const ConstantLinks& links = *energy->constant_links();
    if (!taken.links.empty() && links.damping != taken.links.front()->damping) return false;
    return std::all_of(links.node.begin(), links.node.end(), [&](int node) {
      const auto k = static_cast<size_t>(links.first_node + node);
      return k < sprung.size() && sprung[k] != 0;
    });
  };
  terms->clear();
  for (const Energy* energy : rest) {
    if (fits(energy)) {
      taken.links.push_back(energy->constant_links());
      taken.link_terms.push_back(energy);
    } else {
      terms->push_back(energy);
    }
  }
  return taken;
}

void refuse_unknown_terms(const std::string& integrator, const std::vector<std::unique_ptr<Energy>>& energies) {
  std::vector<const Energy*> terms;
  for (const auto& energy : energies) terms.push_back(energy.get());
  sort_terms(integrator, terms, 0, {});
}

bool takes_known_terms_only(const std::string& integrator) {
  return integrator == "line_dual" || integrator == "xpbd" || integrator == "projective_dynamics";
}

}  // namespace deformable_sim
