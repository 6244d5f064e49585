#include "contact_check.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "deformable_sim/core/contact/body_contacts.h"
#include "deformable_sim/core/contact/contact_finder.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kNoWeight = 1e-9;
constexpr double kNoDistance = 1e-9;  // m

/// Nodes of both sides, each ascending, the side of the smallest node first, and how many are of the first; on a
/// collider: the node and the collider.
using Place = std::array<int, 5>;
using Found = std::map<Place, double>;  // distance

Place place_of(std::vector<int> one, std::vector<int> other) {
  std::sort(one.begin(), one.end());
  std::sort(other.begin(), other.end());
  if (other.front() < one.front()) std::swap(one, other);
  Place place{{-1, -1, -1, -1, static_cast<int>(one.size())}};
  std::copy(one.begin(), one.end(), place.begin());
  std::copy(other.begin(), other.end(), place.begin() + static_cast<std::ptrdiff_t>(one.size()));
  return place;
}

const Body& body_of(const Model& model, int node) {
  return *std::find_if(model.bodies.begin(), model.bodies.end(),
                       [&](const Body& b) { return node < b.first_node + b.node_count; });
}

Place place_of(const BaselineContact& c) {
  if (c.collider >= 0) return {{c.node[0], c.collider, -1, -1, 0}};
  std::vector<int> side[2];
  for (int k = 0; k < 4; ++k) {
    if (c.weight[static_cast<size_t>(k)] > kNoWeight)
      side[k < c.first ? 0 : 1].push_back(c.node[static_cast<size_t>(k)]);
  }
  return place_of(side[0], side[1]);
}

Found found_by(const ContactBaseline& baseline) {
  Found found;
  for (const BaselineContact& c : baseline.contacts()) found.emplace(place_of(c), c.distance);
  return found;
}

Found found_by_library(const World& world, const State& at_rest, const std::vector<Collider>& colliders) {
  const Model& model = world.model();
  const double dt = world.settings().dt;
  ContactConstraints contacts;
  BodyContacts(&model).find(at_rest, dt, {}, Nodes(3, 0), &contacts);
  if (!colliders.empty()) {
    ContactFinder finder(&model);
    finder.set_colliders(colliders);
    std::vector<PoseStep> poses;
    for (const Collider& c : colliders) poses.push_back({c.world_from_collider, c.world_from_collider});
    finder.find(at_rest, dt, poses, std::vector<NodeRole>(static_cast<size_t>(model.node_count()), NodeRole::kFree),
                0.0, &contacts);
  }
  Found found;
  for (const ContactConstraint& c : contacts) {
    double along = 0.0;
    std::vector<int> side[2];
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      along += c.weight[k] * c.normal.dot(at_rest.x.col(c.node[k]));
      if (std::abs(c.weight[k]) > kNoWeight) side[c.weight[k] > 0.0 ? 0 : 1].push_back(c.node[k]);
    }
    if (c.collider < 0) {
      found.emplace(place_of(side[0], side[1]), along);
    } else {
      // A point on its way out is asked for less than the surface: it has no distance, but a contact it is.
      const double distance = along - c.offset + body_of(model, c.node[0]).contact_radius;
      const auto [known, is_new] = found.emplace(Place{{c.node[0], c.collider, -1, -1, 0}}, distance);
      if (!is_new) known->second = std::min(known->second, distance);
    }
  }
  return found;
}

double asked(const Model& model, const Place& place) {
  if (place[4] == 0) return body_of(model, place[0]).contact_radius;
  return body_of(model, place[0]).contact_radius + body_of(model, place[static_cast<size_t>(place[4])]).contact_radius;
}

/// How many of `one` below their limit are not in `other`.
int count_missing(const Model& model, const Found& one, const Found& other, const char* whose, std::string* first) {
  int count = 0;
  for (const auto& [place, distance] : one) {
    if (distance > asked(model, place) - kNoDistance || distance < kNoDistance || other.count(place) > 0) continue;
    if (++count > 1 || !first->empty()) continue;
    *first = std::string(whose) + " alone has";
    for (const int k : place) *first += " " + std::to_string(k);
    *first += " at " + std::to_string(1e3 * distance) + " mm";
  }
  return count;
}

}  // namespace

ContactComparison compare_contacts(const World& world, ContactBaseline* baseline) {
  const std::vector<Collider> colliders = world.snapshot(SnapshotDetail::kMotion).colliders;
  State at_rest = world.state();
  at_rest.v.setZero();
  baseline->find(at_rest.x, at_rest.v, world.settings().dt, colliders);
  const Found ours = found_by(*baseline), theirs = found_by_library(world, at_rest, colliders);
  ContactComparison result;
  for (const auto& [place, distance] : ours) {
    if (distance <= asked(world.model(), place)) ++(place[4] == 0 ? result.on_colliders : result.between_bodies);
  }
  result.missed = count_missing(world.model(), ours, theirs, "the baseline", &result.first);
  result.surplus = count_missing(world.model(), theirs, ours, "the library", &result.first);
  return result;
}

double least_distance_share(const World& world, ContactBaseline* baseline) {
  constexpr double kRestShare = 0.9;
  const Model& model = world.model();
  const Nodes still = Nodes::Zero(3, model.node_count());
  baseline->find(world.state().x, still, world.settings().dt, {});
  double least = 1.0;
  for (const BaselineContact& c : baseline->contacts()) {
    const Body &one = body_of(model, c.node[0]), &other = body_of(model, c.node[3]);
    double wanted = one.contact_radius + other.contact_radius;
    if (&one == &other) {
      const Nodes& rest = one.line ? one.line->rest : one.surface->rest;
      Vec3 apart = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        const auto s = static_cast<size_t>(k);
        apart += (k < c.first ? 1.0 : -1.0) * c.weight[s] * rest.col(c.node[s] - one.first_node);
      }
      wanted = std::min(wanted, kRestShare * apart.norm());
    }
    least = std::min(least, c.distance / wanted);
  }
  return least;
}

}  // namespace bench
}  // namespace deformable_sim
