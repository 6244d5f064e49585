// Commands: each is checked completely before anything changes.
#include <cmath>
#include <utility>

#include "deformable_sim/core/rod_frames.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

constexpr double kFurthest = 1e6;      // m
constexpr double kFastest = 1e4;       // m/s
constexpr double kLeastLength = 1e-6;  // of an edge, of its rest length

int find_body(const Model& model, const std::string& name) {
  const int body = model.find_body(name);
  if (body >= 0) return body;
  std::string known;
  for (const Body& b : model.bodies) known += (known.empty() ? "" : ", ") + b.name;
  throw InputError("no body named '" + name + "'; there are: " + (known.empty() ? "none" : known), Code::kNotFound);
}

void check_body_state(const Model& model, const command::SetBodyState& c) {
  const int body = find_body(model, c.body);
  const Eigen::Index count = model.bodies[static_cast<size_t>(body)].node_count;
  if (c.x.cols() != count || c.v.cols() != count)
    throw InputError("'" + c.body + "' has " + std::to_string(count) + " nodes; got " + std::to_string(c.x.cols()) +
                     " positions and " + std::to_string(c.v.cols()) + " velocities");
  if (!c.x.allFinite() || !c.v.allFinite()) throw InputError("positions and velocities must be finite");
  if (count > 0 && c.x.cwiseAbs().maxCoeff() > kFurthest)
    throw InputError("positions must be within 1e6 m of the origin", Code::kOutOfRange);
  if (count > 0 && c.v.cwiseAbs().maxCoeff() > kFastest)
    throw InputError("velocities must be at most 1e4 m/s", Code::kOutOfRange);
  if (c.rod.size() > 0) check_rod_state(model.bodies[static_cast<size_t>(body)], c.x, c.rod);
}

}  // namespace

void World::watch(std::function<void(const Command&)> applied) {
  applied_ = std::move(applied);
}

Reply World::apply(const Command& any) {
  Parts& w = *parts_;
  const double dt = w.settings.dt;
  struct Visitor {
    Parts& w;
    double dt;
    Reply reply;

    void operator()(const command::Grasp& c) {
      const double stored = w.grasps.stored_energy(w.state);
      reply.nodes = w.grasps.add(c.request, w.state);
      w.held_nodes_changed(stored);
    }
    void operator()(const command::MoveGrasp& c) {
      reply.note = w.grasps.move(c.name, c.world_from_target, c.duration, dt);
    }
    void operator()(const command::SetGraspWaiting& c) { w.grasps.set_waiting(c.name, c.waiting); }
    void operator()(const command::Release& c) {
      if (c.name.empty() && w.grasps.empty()) {
        reply.note = "there is no grasp to release";
        return;
      }
      const double stored = w.grasps.stored_energy(w.state);
      w.grasps.release(c.name);
      w.held_nodes_changed(stored);
    }
    void operator()(const command::AddCollider& c) {
      for (const std::string& body : c.collider.lets_through) find_body(*w.model, body);
      w.colliders.add(c.collider);
      w.colliders_changed();
    }
    void operator()(const command::LetThrough& c) {
      for (const std::string& body : c.bodies) find_body(*w.model, body);
      w.colliders.let_through(c.name, c.bodies);
      w.colliders_changed();
    }
    void operator()(const command::MoveCollider& c) {
      reply.note = w.colliders.move(c.name, c.world_from_collider, c.duration, dt);
    }
    void operator()(const command::RemoveCollider& c) {
      w.colliders.remove(c.name);
      w.colliders_changed();
    }
    void operator()(const command::SetBodyState& c) {
      check_body_state(*w.model, c);
      const int index = w.model->find_body(c.body);
      const Body& body = w.model->bodies[static_cast<size_t>(index)];
      Nodes x = w.state.x;
      x.middleCols(body.first_node, body.node_count) = c.x;
      const double taken_in = w.limiter ? w.limiter->take_in(w.dynamics.kinematics, &x) : 0.0;
      refuse_crossing(body, x);
      w.state.x = x;
      w.state.v.middleCols(body.first_node, body.node_count) = c.v;
      if (c.rod.size() > 0) {
        set_rod_state(*w.model, body, c.rod, &w.state);
      } else if (body.first_segment >= 0) {
        carry_frames(body.first_segment, body.line->segment_count(), body.first_node, body.line->closed, &w.state);
      }
      if (w.grasps.hold_in_place(index, w.state)) reply.note = "held nodes are now held where they were put";
      if (taken_in > 0.0) {
        reply.note += (reply.note.empty() ? "" : "; ") +
                      std::string("beyond the strain limit: nodes were moved by up to ") +
                      std::to_string(1e3 * taken_in) + " mm to be within";
      }
      if (w.contacts) w.contacts->forget_sides();
      if (w.meetings) w.meetings->forget();
      w.state.x_before.resize(3, 0);  // the motion up to here is not that of the new state
      w.state.v_before.resize(3, 0);
      w.stable_dt_age = -1;
      w.sunk_until = w.step_count + 1;
      w.book.begin();
      if (w.controller) w.controller->hurry();
      w.integrator->reset();
    }
    void operator()(const command::Reset&) {
      if (!w.start_crosses.empty())
        throw InputError(w.start_crosses + " where they start; load a scene, or remove one of them",
                         Code::kUnavailable);
      w.start();
      if (w.contacts) w.contacts->forget_sides();
    }

    /// Bodies that cross are not seen as touching until they have come apart.
    void refuse_crossing(const Body& body, const Nodes& x) const {
      if (!w.meetings || body.touches == BodyContact::kNone) return;
      for (const StrainEdge& edge : body.strain_edges)
        if ((x.col(edge.node[0]) - x.col(edge.node[1])).norm() < kLeastLength * edge.rest_length)
          throw InputError("nodes " + std::to_string(edge.node[0] - body.first_node) + " and " +
                           std::to_string(edge.node[1] - body.first_node) + " of '" + body.name +
                           "' lie in one place; bodies that touch others need a direction from node to node");
      const std::string crossing = w.meetings->find_crossing(x);
      if (crossing.find("'" + body.name + "'") != std::string::npos)
        throw InputError(crossing + " in this state; give one in which they lie apart");
    }
  };

  Visitor visitor{w, dt, Reply()};
  try {
    std::visit(visitor, any);
  } catch (const InputError& e) {
    visitor.reply = Reply();
    visitor.reply.status = {e.code(), e.what()};
  }
  if (applied_ && visitor.reply.status.ok()) applied_(any);
  return visitor.reply;
}

}  // namespace deformable_sim
