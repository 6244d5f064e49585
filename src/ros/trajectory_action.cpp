#include "deformable_sim/ros/trajectory_action.h"

#include <utility>

#include <actionlib/server/simple_action_server.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/trajectories.h"

namespace deformable_sim {

namespace {

constexpr double kFeedbackPeriod = 0.05;  // s, wall

double or_standard(double value, double standard, const std::string& what) {
  to_non_negative(value, what);
  return value > 0.0 ? value : standard;
}

TrajectoryGoal to_goal(const msg::FollowGraspTrajectoryGoal& message, Frames* frames) {
  TrajectoryGoal goal;
  goal.trajectories = to_trajectories(message.trajectories, "trajectories", frames);
  goal.allow_partial = message.allow_partial != 0;
  goal.position_tolerance = or_standard(message.position_tolerance, goal.position_tolerance, "position_tolerance");
  goal.rotation_tolerance = or_standard(message.rotation_tolerance, goal.rotation_tolerance, "rotation_tolerance");
  goal.time_tolerance = or_standard(message.time_tolerance, goal.time_tolerance, "time_tolerance");
  return goal;
}

msg::FollowGraspTrajectoryResult result_of(const TrajectoryProgress& progress) {
  msg::FollowGraspTrajectoryResult result;
  fill(progress.status, &result.status);
  for (const GraspProgress& grasp : progress.grasps) {
    result.grasps.push_back(grasp.grasp);
    result.outcomes.push_back(static_cast<std::uint8_t>(grasp.outcome));
    result.position_errors.push_back(grasp.position_error);
  }
  return result;
}

}  // namespace

class TrajectoryAction::Server {
 public:
  Server(const ros::NodeHandle& nh, Simulation* simulation, Frames* frames, std::string frame_id)
      : simulation_(simulation),
        frames_(frames),
        frame_id_(std::move(frame_id)),
        server_(
            nh, "follow_trajectory", [this](const auto& goal) { execute(*goal); }, false) {}

  void start() { server_.start(); }

 private:
  void execute(const msg::FollowGraspTrajectoryGoal& message) {
    const auto run = std::make_shared<TrajectoryRun>();
    TrajectoryProgress progress;
    try {
      const Reply reply = simulation_->follow(to_goal(message, frames_), run);
      if (!reply.status.ok()) throw InputError(reply.status.message, reply.status.code);
    } catch (const InputError& error) {
      progress.status = {error.code(), error.what()};
      server_.setAborted(result_of(progress), error.what());
      return;
    }
    ros::Time stamp;
    bool preempted = false;
    while (!(progress = run->wait(kFeedbackPeriod, &stamp)).is_over) {
      preempted = server_.isPreemptRequested();
      if (preempted || !ros::ok()) {
        const Reply reply = simulation_->stop_following(run, {Code::kUnavailable, "cancelled; grasps stopped"});
        if (!reply.status.ok()) progress.status = reply.status;
        progress = run->wait(kFeedbackPeriod, &stamp);
        break;
      }
      tell(progress, stamp);
    }
    tell(progress, stamp);
    const msg::FollowGraspTrajectoryResult result = result_of(progress);
    if (preempted) {
      server_.setPreempted(result, progress.status.message);
    } else if (progress.status.ok()) {
      server_.setSucceeded(result);
    } else {
      server_.setAborted(result, progress.status.message);
    }
  }

  void tell(const TrajectoryProgress& progress, ros::Time stamp) {
    msg::FollowGraspTrajectoryFeedback feedback;
    feedback.header.frame_id = frame_id_;
    feedback.header.stamp = stamp;
    feedback.time_from_start = progress.time_from_start;
    feedback.progress = progress.progress;
    for (const GraspProgress& grasp : progress.grasps) {
      feedback.grasps.push_back(grasp.grasp);
      feedback.desired.push_back(to_message(grasp.desired));
      feedback.actual.push_back(to_message(grasp.actual));
      feedback.position_errors.push_back(grasp.position_error);
      feedback.forces.push_back(grasp.force);
      feedback.loads.push_back(grasp.load);
    }
    server_.publishFeedback(feedback);
  }

  Simulation* simulation_;
  Frames* frames_;
  std::string frame_id_;
  actionlib::SimpleActionServer<msg::FollowGraspTrajectoryAction> server_;
};

TrajectoryAction::TrajectoryAction(const ros::NodeHandle& private_nh, Simulation* simulation, Frames* frames,
                                   std::string frame_id)
    : nh_(private_nh), simulation_(simulation), frames_(frames), frame_id_(std::move(frame_id)) {}
TrajectoryAction::~TrajectoryAction() = default;

void TrajectoryAction::start() {
  server_ = std::make_unique<Server>(nh_, simulation_, frames_, frame_id_);
  server_->start();
}

void TrajectoryAction::stop() {
  server_.reset();
}

}  // namespace deformable_sim
