// An action server whose topics are read as carefully as all others.
#pragma once

#include <algorithm>
#include <string>

#include <actionlib/server/action_server_base.h>
#include <actionlib_msgs/GoalID.h>
#include <actionlib_msgs/GoalStatusArray.h>
#include <ros/node_handle.h>

#include "deformable_sim/ros/careful_messages.h"

namespace deformable_sim {

/// actionlib's bookkeeping of goals behind careful subscriptions. actionlib::ActionServer adds 5 s to whatever time a
/// goal carries, which throws for the latest ones, and keeps goals of the future and cancelled goals that never come
/// for ever: here times are those of now at most, and the list is bounded. It also forgets goals whenever it tells of
/// them, which goalCallback() has it do while it looks at one of them: here a timer alone forgets.
template <class Spec>
class CarefulActionServer : public actionlib::ActionServerBase<Spec> {
  using Base = actionlib::ActionServerBase<Spec>;

 public:
  using typename Base::GoalHandle;
  ACTION_DEFINITION(Spec)

  /// Callbacks come on the threads that serve the node's callback queue.
  CarefulActionServer(const ros::NodeHandle& nh, const std::string& name, boost::function<void(GoalHandle)> goal,
                      boost::function<void(GoalHandle)> cancel)
      : Base(goal, cancel, false), nh_(nh, name) {}

 private:
  static constexpr std::uint32_t kQueue = 50;
  static constexpr std::size_t kMostGoals = 100;  // remembered
  static constexpr std::size_t kLongestId = 200;  // characters
  static constexpr double kStatusPeriod = 0.2;    // s, wall
  static constexpr double kRemembered = 5.0;      // s

  void initialize() override {
    this->status_list_timeout_ = ros::Duration(kRemembered);
    result_ = nh_.advertise<ActionResult>("result", kQueue);
    feedback_ = nh_.advertise<ActionFeedback>("feedback", kQueue);
    status_ = nh_.advertise<actionlib_msgs::GoalStatusArray>("status", kQueue, true);
    timer_ = nh_.createWallTimer(ros::WallDuration(kStatusPeriod), [this](const ros::WallTimerEvent&) {
      publishStatus();
      forget_old_goals();
    });
    auto goals = careful_subscription<ActionGoal>("goal", kQueue, [this](const auto& goal) { take(*goal); });
    auto cancels =
        careful_subscription<actionlib_msgs::GoalID>("cancel", kQueue, [this](const auto& id) { take(*id); });
    goal_ = nh_.subscribe(goals);
    cancel_ = nh_.subscribe(cancels);
  }

  bool is_known(const std::string& id) {
    const boost::recursive_mutex::scoped_lock lock(this->lock_);
    return std::any_of(this->status_list_.begin(), this->status_list_.end(),
                       [&](const auto& tracker) { return tracker.status_.goal_id.id == id; });
  }

  bool has_room() {
    const boost::recursive_mutex::scoped_lock lock(this->lock_);
    return this->status_list_.size() < kMostGoals;
  }

  void take(const ActionGoal& message) {
    if (message.goal_id.id.size() > kLongestId || (!is_known(message.goal_id.id) && !has_room())) return;
    const auto goal = boost::make_shared<ActionGoal>(message);
    goal->goal_id.stamp = std::min(goal->goal_id.stamp, ros::Time::now());
    this->goalCallback(goal);
  }

  void take(const actionlib_msgs::GoalID& message) {
    if (message.id.size() > kLongestId || (!message.id.empty() && !is_known(message.id) && !has_room())) return;
    const auto id = boost::make_shared<actionlib_msgs::GoalID>(message);
    id->stamp = std::min(id->stamp, ros::Time::now());
    this->cancelCallback(id);
  }

  void publishResult(const actionlib_msgs::GoalStatus& status, const Result& result) override {
    ActionResult message;
    message.header.stamp = ros::Time::now();
    message.status = status;
    message.result = result;
    result_.publish(message);
    publishStatus();
  }

  void publishFeedback(const actionlib_msgs::GoalStatus& status, const Feedback& feedback) override {
    ActionFeedback message;
    message.header.stamp = ros::Time::now();
    message.status = status;
    message.feedback = feedback;
    feedback_.publish(message);
  }

  void publishStatus() override {
    const boost::recursive_mutex::scoped_lock lock(this->lock_);
    if (!this->started_) return;
    actionlib_msgs::GoalStatusArray message;
    message.header.stamp = ros::Time::now();
    for (const auto& tracker : this->status_list_) message.status_list.push_back(tracker.status_);
    status_.publish(message);
  }

  void forget_old_goals() {
    const boost::recursive_mutex::scoped_lock lock(this->lock_);
    const ros::Time now = ros::Time::now();
    this->status_list_.remove_if([&](auto& tracker) {
      if (!tracker.handle_tracker_.expired()) return false;
      // Unset of a cancelled goal without a stamp that has not come, and where the last handle is just being let go;
      // of the future when time went back.
      ros::Time& over = tracker.handle_destruction_time_;
      if (over.isZero() || over > now) over = now;
      return over + this->status_list_timeout_ < now;
    });
  }

  ros::NodeHandle nh_;
  ros::Publisher result_, feedback_, status_;
  ros::Subscriber goal_, cancel_;
  ros::WallTimer timer_;
};

}  // namespace deformable_sim
