#include <ros/console.h>

#include "deformable_sim/ros/careful_messages.h"
#include "deformable_sim/ros/commands.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/grasp_requests.h"
#include "deformable_sim/ros/obstacles.h"

namespace deformable_sim {

namespace {

constexpr int kCommandQueue = 100;
constexpr int kTargetQueue = 1;  // streamed: only the newest counts

}  // namespace

CommandTopics::CommandTopics(const ros::NodeHandle& private_nh, Simulation* simulation, Frames* frames,
                             Warnings* warnings, const AllowedPaths* files)
    : nh_(private_nh), simulation_(simulation), frames_(frames), warnings_(warnings), files_(files) {}

void CommandTopics::start() {
  auto grasps = careful_subscription<msg::GraspCommand>(
      "grasp_command", kCommandQueue, [this](const msg::GraspCommandConstPtr& message) { grasp_command(*message); });
  auto obstacles = careful_subscription<msg::Obstacle>(
      "obstacle", kCommandQueue, [this](const msg::ObstacleConstPtr& message) { obstacle(*message); });
  fixed_ = {nh_.subscribe(grasps), nh_.subscribe(obstacles)};
}

void CommandTopics::update(const std::vector<std::string>& grasp_names) {
  std::map<std::string, ros::Subscriber> next;
  for (const std::string& name : grasp_names) {
    const auto known = targets_.find(name);
    if (known != targets_.end()) {
      next[name] = known->second;
      continue;
    }
    auto targets = careful_subscription<geometry_msgs::PoseStamped>(
        "grasp/" + name + "/target", kTargetQueue,
        [this, name](const geometry_msgs::PoseStampedConstPtr& message) { target(name, *message); });
    // By a handle of its own: a handle remembers all that were ever made by it, 120 bytes each.
    next[name] = ros::NodeHandle(nh_).subscribe(targets);
  }
  targets_.swap(next);
}

void CommandTopics::target(const std::string& grasp, const geometry_msgs::PoseStamped& pose) {
  const std::string what = "target of grasp '" + printable(grasp) + "'";
  try {
    simulation_->post({command::MoveGrasp{grasp, to_world_pose(pose, "pose", frames_), 0.0}}, reporter(what));
  } catch (const InputError& error) {
    refuse(what, error.what());
  }
}

void CommandTopics::grasp_command(const msg::GraspCommand& message) {
  const std::string what = "grasp_command '" + printable(message.name) + "'";
  try {
    simulation_->post(to_commands(message, frames_), reporter(what));
  } catch (const InputError& error) {
    refuse(what, error.what());
  }
}

void CommandTopics::obstacle(const msg::Obstacle& message) {
  const std::string what = "obstacle '" + printable(message.name) + "'";
  try {
    if (message.action == msg::Obstacle::ADD) {
      const ObstacleRequest request = to_obstacle(message, *files_, frames_);
      if (request.frame_from_collider) {
        simulation_->post_attach(request.collider, *request.frame_from_collider, reporter(what));
      } else {
        simulation_->post({command::AddCollider{request.collider}}, reporter(what));
      }
    } else if (message.action == msg::Obstacle::MOVE) {
      simulation_->post({to_obstacle_move(message, frames_)}, reporter(what));
    } else if (message.action == msg::Obstacle::REMOVE) {
      check_name("name", message.name);
      simulation_->post({command::RemoveCollider{message.name}}, reporter(what));
    } else {
      throw InputError("action: " + std::to_string(message.action) + ", allowed are ADD 0, MOVE 1, REMOVE 2");
    }
  } catch (const InputError& error) {
    refuse(what, error.what());
  }
}

Done CommandTopics::reporter(const std::string& what) {
  return [this, what](const Reply& reply) {
    if (!reply.status.ok()) refuse(what, reply.status.message);
    if (!reply.note.empty()) warnings_->event(what + ": " + reply.note);
  };
}

void CommandTopics::refuse(const std::string& what, const std::string& why) {
  warnings_->event(what + " refused: " + why);
  ROS_WARN_STREAM_THROTTLE_NAMED(1.0, "commands", what << " refused: " << why);
}

}  // namespace deformable_sim
