#include "deformable_sim/rviz/ros_link.h"

#include <chrono>
#include <utility>

#include <QDir>

#include <XmlRpcValue.h>
#include <dynamic_reconfigure/Reconfigure.h>
#include <ros/master.h>
#include <ros/package.h>
#include <ros/this_node.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include "deformable_sim/LoadScene.h"
#include "deformable_sim/Step.h"

namespace deformable_sim {
namespace {

// The node answers a command within 5 s, if only to say that it could not (doc/ros_api.md).
constexpr double kPatience = 8.0;        // s
constexpr double kLoadPatience = 120.0;  // s; the first use of a large mesh takes some seconds
constexpr double kWatchPeriod = 0.2;     // s
constexpr char kStatusType[] = "deformable_sim/SimStatus";

}  // namespace

RosLink::RosLink() : spinner_(1, &queue_) {
  handle_.setCallbackQueue(&queue_);
  watchdog_ = handle_.createWallTimer(ros::WallDuration(kWatchPeriod),
                                      [this](const ros::WallTimerEvent&) { abandon_late_call(); });
  spinner_.start();
  worker_ = std::thread([this] { work(); });
}

RosLink::~RosLink() {
  {
    std::unique_lock<std::mutex> lock(mutex_);
    ending_ = true;
    changed_.notify_all();
    // A call may begin just after it was to be abandoned: ask again until the worker is through.
    while (!changed_.wait_for(lock, std::chrono::milliseconds(20), [this] { return ended_; })) call_.shutdown();
  }
  worker_.join();
  spinner_.stop();
}

void RosLink::enqueue(std::function<void()> job) {
  const std::lock_guard<std::mutex> lock(mutex_);
  jobs_.push_back(std::move(job));
  changed_.notify_all();
}

void RosLink::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
    if (ending_) break;
    const std::function<void()> job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job();
    lock.lock();
  }
  lock.unlock();
  unsubscribe();
  lock.lock();
  ended_ = true;
  changed_.notify_all();
}

// --- what is heard
// ----------------------------------------------------------------------------------------------------

void RosLink::open(const QString& node) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    node_ = node;
  }
  abandon_call();
  enqueue([this, node] { subscribe(node); });
}

void RosLink::close() {
  enqueue([this] { unsubscribe(); });
}

void RosLink::subscribe(const QString& node) {
  unsubscribe();
  if (!ros::master::check()) return;  // subscribing would wait for a master; the view opens again
  const std::string prefix = node.toStdString() + "/";
  subscribers_.push_back(handle_.subscribe<SimStatus>(
      prefix + "status", 10, [this, node](const SimStatusConstPtr& status) { Q_EMIT status_received(node, status); }));
  subscribers_.push_back(handle_.subscribe<GraspStateArray>(
      prefix + "grasps", 2,
      [this, node](const GraspStateArrayConstPtr& grasps) { Q_EMIT grasps_received(node, grasps); }));
  subscribers_.push_back(handle_.subscribe<dynamic_reconfigure::Config>(
      prefix + "parameter_updates", 2,
      [this, node](const dynamic_reconfigure::ConfigConstPtr& values) { on_parameters(node, *values); }));
}

void RosLink::unsubscribe() {
  for (ros::Subscriber& subscriber : subscribers_) subscriber.shutdown();
  subscribers_.clear();
}

void RosLink::on_parameters(const QString& node, const dynamic_reconfigure::Config& values) {
  for (const auto& parameter : values.strs) {
    if (parameter.name == "color_by") Q_EMIT color_by_received(node, QString::fromStdString(parameter.value));
  }
}

// --- what is asked
// ----------------------------------------------------------------------------------------------------

template <class Service>
bool RosLink::call(const std::string& name, Service* service, double patience) {
  // Only the call of a persistent client can be ended from another thread.
  ros::ServiceClient client = handle_.serviceClient<Service>(name, true);
  if (!client.isValid()) return false;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (ending_) return false;
    call_ = client;
    call_deadline_ = ros::WallTime::now() + ros::WallDuration(patience);
  }
  const bool answered = client.call(*service);
  const std::lock_guard<std::mutex> lock(mutex_);
  call_ = ros::ServiceClient();
  return answered;
}

void RosLink::abandon_call() {
  const std::lock_guard<std::mutex> lock(mutex_);
  call_.shutdown();
}

void RosLink::abandon_late_call() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (call_ && ros::WallTime::now() > call_deadline_) call_.shutdown();
}

template <class Service>
void RosLink::request(const std::string& name, Service service, double patience,
                      std::function<Answer(const Service&)> judge) {
  const std::lock_guard<std::mutex> lock(mutex_);
  jobs_.push_back([this, node = node_, name, service, patience, judge]() mutable {
    if (!call(node.toStdString() + "/" + name, &service, patience)) {
      Q_EMIT answered(node, false, "no answer from " + node);
      return;
    }
    const Answer answer = judge(service);
    Q_EMIT answered(node, answer.accepted, QString::fromStdString(answer.message));
  });
  changed_.notify_all();
}

void RosLink::set_paused(bool paused) {
  std_srvs::SetBool service;
  service.request.data = paused;
  request<std_srvs::SetBool>("pause", service, kPatience, [](const std_srvs::SetBool& s) {
    return Answer{s.response.success != 0, s.response.message};
  });
}

void RosLink::step(unsigned count) {
  Step service;
  service.request.steps = count;
  request<Step>("step", service, kPatience, [](const Step& s) {
    return Answer{s.response.status.code == Status::OK, s.response.status.message};
  });
}

void RosLink::reset() {
  request<std_srvs::Trigger>("reset", std_srvs::Trigger(), kPatience, [](const std_srvs::Trigger& s) {
    return Answer{s.response.success != 0, s.response.message};
  });
}

void RosLink::load_scene(const QString& name_or_file) {
  LoadScene service;
  service.request.file = name_or_file.toStdString();
  request<LoadScene>("load_scene", service, kLoadPatience, [](const LoadScene& s) {
    return Answer{s.response.status.code == Status::OK, s.response.status.message};
  });
}

void RosLink::set_color_by(const QString& quantity) {
  dynamic_reconfigure::Reconfigure service;
  dynamic_reconfigure::StrParameter parameter;
  parameter.name = "color_by";
  parameter.value = quantity.toStdString();
  service.request.config.strs.push_back(parameter);
  request<dynamic_reconfigure::Reconfigure>(
      "set_parameters", service, kPatience, [wanted = parameter.value](const dynamic_reconfigure::Reconfigure& s) {
        // The values there are now: one that was refused is set back.
        for (const auto& value : s.response.config.strs) {
          if (value.name == "color_by" && value.value == wanted) return Answer{true, ""};
        }
        return Answer{false, "color_by '" + wanted + "' was refused; the warnings say why"};
      });
}

void RosLink::look_around() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (looking_) return;
    looking_ = true;
  }
  enqueue([this] {
    find_nodes();
    find_scenes();
    const std::lock_guard<std::mutex> lock(mutex_);
    looking_ = false;
  });
}

void RosLink::find_nodes() {
  // Not ros::master::getTopics, which waits for a master that is gone.
  XmlRpc::XmlRpcValue arguments, answer, topics;
  arguments[0] = ros::this_node::getName();
  if (!ros::master::execute("getTopicTypes", arguments, answer, topics, false)) return;
  QStringList nodes;
  for (int i = 0; i < topics.size(); ++i) {
    const QString topic = QString::fromStdString(topics[i][0]);
    if (std::string(topics[i][1]) == kStatusType && topic.endsWith("/status")) nodes << topic.chopped(7);
  }
  nodes.sort();
  Q_EMIT nodes_found(nodes);
}

void RosLink::find_scenes() {
  const std::string package = ros::package::getPath("deformable_sim");
  if (package.empty()) return;
  QStringList names;
  for (const QString& file :
       QDir(QString::fromStdString(package) + "/config/scenes").entryList({"*.yaml"}, QDir::Files)) {
    names << file.chopped(5);
  }
  Q_EMIT scenes_found(names);
}

}  // namespace deformable_sim
