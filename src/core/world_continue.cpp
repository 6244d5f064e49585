// A world that goes on where another has come to.
#include <utility>
#include <vector>

#include "deformable_sim/core/rod_frames.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

/// Index in `then` of each body of `now` that is the same one, as far as motion goes; else -1.
std::vector<int> partners(const Model& now, const Model& then) {
  std::vector<int> partner;
  for (const Body& body : now.bodies) {
    const int other = then.find_body(body.name);
    const bool same = other >= 0 && then.bodies[static_cast<size_t>(other)].node_count == body.node_count &&
                      then.bodies[static_cast<size_t>(other)].kind == body.kind &&
                      (then.bodies[static_cast<size_t>(other)].first_segment < 0) == (body.first_segment < 0);
    partner.push_back(same ? other : -1);
  }
  return partner;
}

void take_motion(const Model& now, const Body& body, const Model& then, const Body& other, const State& from,
                 State* to) {
  to->x.middleCols(body.first_node, body.node_count) = from.x.middleCols(other.first_node, other.node_count);
  to->v.middleCols(body.first_node, body.node_count) = from.v.middleCols(other.first_node, other.node_count);
  if (body.first_segment < 0) return;
  RodState rod = rod_state(then, other, from);
  rod.topRows<2>() *= body.radius_of_gyration / other.radius_of_gyration;  // columns hold angles times that
  to->tangents.middleCols(body.first_segment, rod.cols()) = from.tangents.middleCols(other.first_segment, rod.cols());
  set_rod_state(now, body, rod, to);
}

}  // namespace

void World::continue_from(const World& before) {
  Parts& now = *parts_;
  const Parts& then = *before.parts_;
  if (now.settings.dt != then.settings.dt) throw InputError("a world goes on with the same dt only", Code::kInternal);
  const std::vector<int> partner = partners(*now.model, *then.model);
  State state = now.model->initial;
  std::vector<char> is_continued;
  for (size_t b = 0; b < partner.size(); ++b) {
    is_continued.push_back(partner[b] >= 0);
    if (partner[b] < 0) continue;
    take_motion(*now.model, now.model->bodies[b], *then.model, then.model->bodies[static_cast<size_t>(partner[b])],
                then.state, &state);
  }
  if (now.meetings) {
    const std::string crossing = now.meetings->find_crossing(state.x);
    for (size_t b = 0; b < partner.size() && !crossing.empty(); ++b)
      if (partner[b] < 0 && crossing.find("'" + now.model->bodies[b].name + "'") != std::string::npos)
        throw InputError(crossing + " now; place it apart, or leave out touches", Code::kUnavailable);
  }
  now.grasps.continue_from(then.grasps, is_continued);
  now.colliders = then.colliders;
  now.state = std::move(state);
  now.step_count = then.step_count;
  now.state.time = then.state.time;
  now.colliders_changed();
  now.held_nodes_changed();
  if (then.controller) now.set_control(then.controller->settings());
}

}  // namespace deformable_sim
