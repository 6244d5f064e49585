#include "deformable_sim/core/rope/rope_chain.h"

#include <algorithm>

#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/line_bending.h"

namespace deformable_sim {
namespace {

using Springs = ElementEnergy<Spring>;

/// All nodes in one row; false where something does not fit into it.
class Row {
 public:
  explicit Row(int n) : tied_(static_cast<size_t>(n), 0) {
    all_.count = n;
    all_.links.resize(static_cast<size_t>(n));
    all_.spans.resize(static_cast<size_t>(n));
    all_.joints.resize(static_cast<size_t>(n));
  }

  bool add(const Springs& springs) {
    for (const Springs::Element& e : springs.elements()) {
      const int first = std::min(e.node[0], e.node[1]), reach = std::max(e.node[0], e.node[1]) - first;
      if (reach < 1 || reach > 2) return false;
      RopeChain::Spring& place = (reach == 1 ? all_.links : all_.spans)[static_cast<size_t>(first)];
      if (place.stiffness != 0.0 || place.damping != 0.0) return false;
      place = {e.rest.stiffness, e.rest.length, e.rest.damping};
      tie(first, reach);
    }
    return true;
  }

  bool add(const LineBending& bending) {
    for (const LineBending::Joint& j : bending.joints()) {
      const int first = j.node[0];
      if (j.node[1] != first + 1 || j.node[2] != first + 2) return false;
      RopeChain::Joint& place = all_.joints[static_cast<size_t>(first)];
      if (place.stiffness != 0.0) return false;
      place = {-j.share[0], j.share[2], j.stiffness, bending.damping()};
      tie(first, 2);
    }
    return true;
  }

  std::vector<RopeChain> parts() const {
    std::vector<RopeChain> chains;
    for (int begin = 0, end; begin < all_.count; begin = end) {
      for (end = begin + 1; end < all_.count && tied_[static_cast<size_t>(end) - 1] != 0; ++end) {
      }
      chains.push_back(part(begin, end));
    }
    return chains;
  }

 private:
  void tie(int first, int reach) {
    for (int k = 0; k < reach; ++k) tied_[static_cast<size_t>(first + k)] = 1;
  }

  RopeChain part(int begin, int end) const {
    RopeChain chain;
    chain.first_node = begin;
    chain.count = end - begin;
    const auto cut = [&](const auto& from) {
      return std::decay_t<decltype(from)>(from.begin() + begin, from.begin() + end);
    };
    chain.links = cut(all_.links);
    chain.spans = cut(all_.spans);
    chain.joints = cut(all_.joints);
    const auto none = [](const RopeChain::Spring& s) { return s.stiffness == 0.0 && s.damping == 0.0; };
    if (std::all_of(chain.spans.begin(), chain.spans.end(), none)) chain.spans.clear();
    const auto damped = [](const auto& part) { return part.damping > 0.0; };
    chain.damped = std::any_of(chain.links.begin(), chain.links.end(), damped) ||
                   std::any_of(chain.spans.begin(), chain.spans.end(), damped) ||
                   std::any_of(chain.joints.begin(), chain.joints.end(), damped);
    return chain;
  }

  RopeChain all_;
  std::vector<char> tied_;  // to the next node
};

}  // namespace

std::optional<std::vector<RopeChain>> find_chains(int n, const std::vector<const Energy*>& energies) {
  Row row(n);
  for (const Energy* energy : energies) {
    if (const auto* springs = dynamic_cast<const Springs*>(energy)) {
      if (!row.add(*springs)) return std::nullopt;
    } else if (const auto* bending = dynamic_cast<const LineBending*>(energy)) {
      if (!row.add(*bending)) return std::nullopt;
    }
  }
  return row.parts();
}

bool is_chain_term(const Energy& energy) {
  return dynamic_cast<const Springs*>(&energy) != nullptr || dynamic_cast<const LineBending*>(&energy) != nullptr;
}

}  // namespace deformable_sim
