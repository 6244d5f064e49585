// A world that goes on where another has come to.
#include <utility>
#include <vector>

#include "deformable_sim/core/archive.h"
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

/// Positions and velocities one step back, of those that have them; others came as they move now.
void take_history(const Model& now, const Model& then, const std::vector<int>& partner, const State& from, State* to) {
  if (from.v_before.cols() == 0) return;
  to->dt_before = from.dt_before;
  const auto take = [&](const Nodes& old, Nodes* fresh) {
    for (size_t b = 0; b < partner.size(); ++b) {
      if (partner[b] < 0) continue;
      const Body &body = now.bodies[b], &other = then.bodies[static_cast<size_t>(partner[b])];
      fresh->middleCols(body.first_node, body.node_count) = old.middleCols(other.first_node, other.node_count);
      if (body.first_segment < 0) continue;
      fresh->middleCols(now.point_count() + body.first_segment, body.line->segment_count()) =
          body.radius_of_gyration / other.radius_of_gyration *
          old.middleCols(then.point_count() + other.first_segment, body.line->segment_count());
    }
  };
  to->v_before = to->v;
  take(from.v_before, &to->v_before);
  if (from.x_before.cols() == 0) return;
  to->x_before = to->x - from.dt_before * to->v;
  take(from.x_before, &to->x_before);
}

/// The same bodies at the same places among the nodes.
bool is_same_layout(const Model& now, const Model& then, const std::vector<int>& partner) {
  bool same = now.bodies.size() == then.bodies.size();
  for (size_t b = 0; b < partner.size() && same; ++b)
    same = partner[b] == static_cast<int>(b) && now.bodies[b].touches == then.bodies[b].touches &&
           now.bodies[b].contact_at_faces == then.bodies[b].contact_at_faces &&
           now.bodies[b].contact_anywhere == then.bodies[b].contact_anywhere;
  return same;
}

/// By way of a saved state.
template <class T>
void carry_over(T* from, T* to) {
  Archive written = Archive::looking_on();
  from->pass(&written);
  Archive read(written.bytes());
  to->pass(&read);
  read.end();
}

}  // namespace

void World::continue_from(World& before) {
  Parts& now = *parts_;
  Parts& then = *before.parts_;
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
  take_history(*now.model, *then.model, partner, then.state, &state);
  if (then.state.limit_tension.size() == static_cast<Eigen::Index>(now.model->strain_limits.size()))
    state.limit_tension = then.state.limit_tension;
  const double dt_before = state.dt_before;
  now.state = std::move(state);
  now.step_count = then.step_count;
  now.state.time = then.state.time;
  now.colliders_changed();
  now.bind_terms();
  now.state.dt_before = dt_before;
  if (then.controller) {
    now.set_control(then.controller->settings());
    carry_over(then.controller.get(), now.controller.get());
  }
  if (!is_same_layout(*now.model, *then.model, partner)) return;
  if (now.contacts) carry_over(then.contacts.get(), now.contacts.get());
  if (now.meetings) carry_over(then.meetings.get(), now.meetings.get());
}

}  // namespace deformable_sim
