#include <algorithm>
#include <cmath>
#include <utility>

#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "deformable_sim/core/contact/body_distance.h"
#include "deformable_sim/ros/careful_messages.h"
#include "deformable_sim/ros/commands.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/grasp_requests.h"
#include "deformable_sim/ros/obstacles.h"
#include "deformable_sim/ros/state_messages.h"
#include "serve.h"

namespace deformable_sim {

namespace {

constexpr double kMostSteps = 1e6;  // of one call

Nodes to_nodes(const std::vector<double>& values, const Body& body, const std::string& what) {
  if (values.size() != 3 * static_cast<std::size_t>(body.node_count)) {
    throw InputError(what + ": " + std::to_string(values.size()) + " numbers, body '" + body.name + "' needs " +
                     std::to_string(3 * body.node_count) + " (3 a node)");
  }
  const Nodes nodes = Eigen::Map<const Nodes>(values.data(), 3, body.node_count);
  if (!nodes.allFinite()) throw InputError(what + ": not finite");
  return nodes;
}

/// Those named, in their order; without names those that the body may touch.
std::vector<Collider> chosen_colliders(const std::vector<Collider>& all, const std::vector<std::string>& names,
                                       const std::string& body) {
  std::vector<Collider> chosen;
  std::string known;
  for (const Collider& collider : all) {
    known += (known.empty() ? "" : ", ") + collider.name;
    if (names.empty() && !lets_through(collider, body)) chosen.push_back(collider);
  }
  for (const std::string& name : names) {
    const auto at = std::find_if(all.begin(), all.end(), [&name](const Collider& c) { return c.name == name; });
    if (at == all.end()) {
      throw InputError(
          "obstacles: '" + printable(name) + "' is not in the world; there are " + (known.empty() ? "none" : known),
          Code::kNotFound);
    }
    chosen.push_back(*at);
  }
  if (chosen.empty()) throw InputError("obstacles: none that '" + body + "' may touch", Code::kNotFound);
  return chosen;
}

const Body& find_body(const Model& model, const std::string& name) {
  const int index = model.find_body(name);
  if (index >= 0) return model.bodies[index];
  std::string known;
  for (const Body& body : model.bodies) known += (known.empty() ? "" : ", ") + body.name;
  throw InputError("body '" + printable(name) + "' is not in the scene; its bodies are " + known, Code::kNotFound);
}

}  // namespace

Services::Services(const ros::NodeHandle& private_nh, const Parameters& parameters, Simulation* simulation,
                   Frames* frames, SceneChanges* changes, Rollouts* rollouts, const AllowedPaths* files)
    : nh_(private_nh),
      frame_id_(parameters.frame_id),
      simulation_(simulation),
      frames_(frames),
      changes_(changes),
      rollouts_(rollouts),
      files_(files),
      saved_states_(parameters.state_dir) {}

void Services::start() {
  advertise_grasps();
  advertise_time();
  advertise_scene();
  advertise_changes();
}

std::vector<std::string> Services::names() const {
  std::vector<std::string> names;
  for (const ros::ServiceServer& server : servers_) names.push_back(server.getService());
  return names;
}

void Services::advertise_grasps() {
  servers_.push_back(serve<msg::GraspRequest, msg::GraspResponse>(nh_, "grasp", [this](const auto& q, auto* response) {
    const Status status = guarded([&] {
      const Reply reply = simulation_->apply(
          {to_grasp(q.name, q.body, q.selection, q.follow_frame, q.max_force, q.max_speed, q.stiffness, frames_)});
      response->nodes.assign(reply.nodes.begin(), reply.nodes.end());
      return answer(reply);
    });
    fill(status, &response->status);
  }));
  servers_.push_back(
      serve<msg::MoveGraspRequest, msg::MoveGraspResponse>(nh_, "move_grasp", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          check_name("name", q.name);
          const double duration = to_non_negative(q.duration.toSec(), "duration");
          return answer(
              simulation_->apply({command::MoveGrasp{q.name, to_world_pose(q.target, "target", frames_), duration}}));
        });
        fill(status, &response->status);
      }));
  servers_.push_back(
      serve<msg::ReleaseRequest, msg::ReleaseResponse>(nh_, "release", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          if (!q.name.empty()) check_name("name", q.name);
          return answer(simulation_->apply({command::Release{q.name}}));
        });
        fill(status, &response->status);
      }));
}

void Services::advertise_time() {
  servers_.push_back(serve<std_srvs::SetBoolRequest, std_srvs::SetBoolResponse>(
      nh_, "pause", [this](const auto& request, auto* response) {
        fill_std(guarded([&] { return answer(simulation_->pause(request.data)); }), response);
      }));
  servers_.push_back(
      serve<std_srvs::TriggerRequest, std_srvs::TriggerResponse>(nh_, "reset", [this](const auto&, auto* response) {
        fill_std(guarded([&] { return answer(simulation_->reset()); }), response);
      }));
  servers_.push_back(
      serve<msg::SaveStateRequest, msg::SaveStateResponse>(nh_, "save_state", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          SavedState state;
          const Reply reply = simulation_->save(&state);
          if (!reply.status.ok()) return reply.status;
          saved_states_.put(q.name, q.file, state);
          response->time = state.time;
          return Status();
        });
        fill(status, &response->status);
      }));
  servers_.push_back(serve<msg::RestoreStateRequest, msg::RestoreStateResponse>(
      nh_, "restore_state", [this](const auto& q, auto* response) {
        const Status status = guarded([&] {
          SavedState state = saved_states_.get(q.name, q.file);
          response->time = state.time;
          return answer(simulation_->restore(std::move(state)));
        });
        fill(status, &response->status);
      }));
  servers_.push_back(serve<msg::StepRequest, msg::StepResponse>(
      nh_, "step", [this](const auto& request, auto* response) { step(request, response); }));
}

void Services::advertise_scene() {
  servers_.push_back(
      serve<std_srvs::TriggerRequest, std_srvs::TriggerResponse>(nh_, "describe", [this](const auto&, auto* response) {
        std::string text;
        fill_std(guarded([&] { return answer(simulation_->describe(&text)); }), response);
        if (response->success) response->message = text;
      }));
  servers_.push_back(serve<msg::AddObstacleRequest, msg::AddObstacleResponse>(
      nh_, "add_obstacle", [this](const auto& request, auto* response) {
        fill(guarded([&] { return answer(add_obstacle(request)); }), &response->status);
      }));
  servers_.push_back(serve<msg::RemoveObstacleRequest, msg::RemoveObstacleResponse>(
      nh_, "remove_obstacle", [this](const auto& request, auto* response) {
        const Status status = guarded([&] {
          check_name("name", request.name);
          return answer(simulation_->apply({command::RemoveCollider{request.name}}));
        });
        fill(status, &response->status);
      }));
  servers_.push_back(serve<msg::LetThroughRequest, msg::LetThroughResponse>(
      nh_, "let_through", [this](const auto& request, auto* response) {
        const Status status = guarded([&] {
          if (request.obstacle.empty()) throw InputError("obstacle: empty; the name of an obstacle or robot.<link>");
          return answer(simulation_->apply({command::LetThrough{printable(request.obstacle), request.bodies}}));
        });
        fill(status, &response->status);
      }));
  servers_.push_back(serve<msg::GetDistanceRequest, msg::GetDistanceResponse>(
      nh_, "get_distance", [this](const auto& request, auto* response) { get_distance(request, response); }));
  servers_.push_back(serve<msg::GetStateRequest, msg::GetStateResponse>(
      nh_, "get_state", [this](const auto& request, auto* response) { get_state(request, response); }));
  servers_.push_back(serve<msg::SetStateRequest, msg::SetStateResponse>(
      nh_, "set_state", [this](const auto& request, auto* response) { set_state(request, response); }));
}

void Services::step(const msg::StepRequest& request, msg::StepResponse* response) {
  const Status status = guarded([&]() -> Status {
    const double seconds = to_non_negative(request.seconds, "seconds");
    if ((request.steps > 0) == (seconds > 0.0)) throw InputError("steps, seconds: one of the two must be more than 0");
    const double steps = request.steps > 0 ? request.steps : std::max(1.0, std::round(seconds / simulation_->dt()));
    if (steps > kMostSteps) throw InputError("more than 1000000 steps in one call", Code::kOutOfRange);
    const Simulation::StepAnswer answer = simulation_->step(static_cast<std::uint32_t>(steps));
    response->time = answer.time;
    response->steps = answer.steps;
    return answer.status;
  });
  fill(status, &response->status);
}

Reply Services::add_obstacle(const msg::AddObstacleRequest& request) {
  const ObstacleRequest obstacle = to_obstacle(request.obstacle, *files_, frames_);
  if (obstacle.frame_from_collider) return simulation_->attach(obstacle.collider, *obstacle.frame_from_collider);
  return simulation_->apply({command::AddCollider{obstacle.collider}});
}

void Services::get_state(const msg::GetStateRequest& request, msg::GetStateResponse* response) {
  const Status status = guarded([&] {
    Snapshot snapshot;
    ros::Time stamp;
    const Reply reply = simulation_->snapshot(&snapshot, &stamp);
    if (!reply.status.ok()) return reply.status;
    find_body(*snapshot.model, request.body);
    response->state = body_state_message(snapshot, snapshot.model->find_body(request.body), frame_id_, stamp);
    return Status();
  });
  fill(status, &response->status);
}

void Services::get_distance(const msg::GetDistanceRequest& request, msg::GetDistanceResponse* response) {
  const Status status = guarded([&] {
    Snapshot snapshot;
    ros::Time stamp;
    const Reply reply = simulation_->snapshot(&snapshot, &stamp);
    if (!reply.status.ok()) return reply.status;
    const Body& body = find_body(*snapshot.model, request.body);
    const std::vector<Collider> colliders = chosen_colliders(snapshot.colliders, request.obstacles, body.name);
    const BodyDistance found =
        body_distance(*snapshot.model, snapshot.model->find_body(body.name), snapshot.x, colliders);
    const Collider& nearest = colliders[static_cast<std::size_t>(found.collider)];
    response->header.stamp = stamp;
    response->header.frame_id = frame_id_;
    response->distance = found.distance;
    response->on_body = to_point(found.on_body);
    response->on_obstacle = to_point(found.on_collider);
    response->obstacle = nearest.name;
    response->link = nearest.frame;
    return Status();
  });
  fill(status, &response->status);
}

void Services::set_state(const msg::SetStateRequest& request, msg::SetStateResponse* response) {
  const Status status = guarded([&] {
    const msg::BodyState& state = request.state;
    if (!state.header.frame_id.empty() && state.header.frame_id != frame_id_) {
      throw InputError("state.header.frame_id: '" + printable(state.header.frame_id) + "', states are exact and in '" +
                       frame_id_ + "' only");
    }
    const std::shared_ptr<const Model> model = simulation_->model();
    const Body& body = find_body(*model, state.body);
    command::SetBodyState command;
    command.body = state.body;
    command.x = to_nodes(state.positions, body, "state.positions");
    command.v = to_nodes(state.velocities, body, "state.velocities");
    if (state.segments.size() % 6 != 0) throw InputError("state.segments: 6 numbers a segment, or none");
    command.rod = Eigen::Map<const RodState>(state.segments.data(), 6, state.segments.size() / 6);
    return answer(simulation_->apply({command}));
  });
  fill(status, &response->status);
}

}  // namespace deformable_sim
