#include "deformable_sim/ros/trajectory_action.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "deformable_sim/ros/careful_action_server.h"
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

/// Goals are taken on the node's callback threads and followed on a thread of its own, one at a time.
class TrajectoryAction::Server {
  using ActionServer = CarefulActionServer<msg::FollowGraspTrajectoryAction>;
  using Goal = ActionServer::GoalHandle;

 public:
  Server(const ros::NodeHandle& nh, Simulation* simulation, Frames* frames, std::string frame_id)
      : simulation_(simulation),
        frames_(frames),
        frame_id_(std::move(frame_id)),
        server_(
            nh, "follow_trajectory", [this](Goal goal) { take(std::move(goal)); },
            [this](const Goal& goal) { cancel(goal); }) {
    server_.start();
    thread_ = std::thread([this] { run(); });
  }

  ~Server() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

 private:
  /// The newest goal takes the place of the one that is followed, and of one that waits for its end.
  void take(Goal goal) {
    std::optional<Goal> passed_over;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(next_, passed_over);
      next_ = std::move(goal);
      stop_ = true;
    }
    changed_.notify_all();
    if (passed_over) passed_over->setRejected({}, "a newer goal came");
  }

  void cancel(const Goal& goal) {
    std::optional<Goal> waiting;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (next_ && *next_ == goal) {
        std::swap(next_, waiting);
      } else if (now_ && *now_ == goal) {
        stop_ = true;
      }
    }
    if (waiting) waiting->setCanceled({}, "cancelled before it began");
  }

  bool is_to_stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return stop_ || stopping_;
  }

  void run() {
    while (true) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        now_.reset();
        changed_.wait(lock, [this] { return next_ || stopping_; });
        if (stopping_) return;
        std::swap(now_, next_);
        next_.reset();
        stop_ = false;
      }
      now_->setAccepted();
      follow(*now_->getGoal());
    }
  }

  void follow(const msg::FollowGraspTrajectoryGoal& message) {
    const auto run = std::make_shared<TrajectoryRun>();
    TrajectoryProgress progress;
    try {
      const Reply reply = simulation_->follow(to_goal(message, frames_), run);
      if (!reply.status.ok()) throw InputError(reply.status.message, reply.status.code);
    } catch (const InputError& error) {
      progress.status = {error.code(), error.what()};
      now_->setAborted(result_of(progress), error.what());
      return;
    }
    ros::Time stamp;
    bool stopped = false;
    while (!(progress = run->wait(kFeedbackPeriod, &stamp)).is_over) {
      if (is_to_stop()) {
        stopped = true;
        const Reply reply = simulation_->stop_following(run, {Code::kUnavailable, "cancelled; grasps stopped"});
        progress = run->wait(kFeedbackPeriod, &stamp);
        if (!reply.status.ok()) progress.status = reply.status;
        break;
      }
      tell(progress, stamp);
    }
    tell(progress, stamp);
    const msg::FollowGraspTrajectoryResult result = result_of(progress);
    if (stopped) {
      now_->setCanceled(result, progress.status.message);
    } else if (progress.status.ok()) {
      now_->setSucceeded(result);
    } else {
      now_->setAborted(result, progress.status.message);
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
    now_->publishFeedback(feedback);
  }

  Simulation* simulation_;
  Frames* frames_;
  std::string frame_id_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Goal> now_, next_;  // now_ is changed by thread_ alone, with the mutex
  bool stop_ = false;               // now_ is to end
  bool stopping_ = false;
  ActionServer server_;
  std::thread thread_;
};

TrajectoryAction::TrajectoryAction(const ros::NodeHandle& private_nh, Simulation* simulation, Frames* frames,
                                   std::string frame_id)
    : nh_(private_nh), simulation_(simulation), frames_(frames), frame_id_(std::move(frame_id)) {}
TrajectoryAction::~TrajectoryAction() = default;

void TrajectoryAction::start() {
  server_ = std::make_unique<Server>(nh_, simulation_, frames_, frame_id_);
}

void TrajectoryAction::stop() {
  server_.reset();
}

}  // namespace deformable_sim
