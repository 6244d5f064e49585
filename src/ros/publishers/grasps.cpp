// ~grasps and ~grasp/<name>/wrench.
#include <algorithm>
#include <map>

#include <geometry_msgs/WrenchStamped.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/state_messages.h"

namespace deformable_sim {

namespace {

class Grasps : public TopicsPublisher {
 public:
  explicit Grasps(const PublisherContext& context) : frame_id_(context.frame_id) {
    topics_.push_back(Topic::advertise<msg::GraspStateArray>(context, "grasps"));
  }

  void publish(const Instant& instant) override {
    msg::GraspStateArray message;
    message.header.frame_id = frame_id_;
    message.header.stamp = instant.stamp;
    for (const GraspReport& grasp : instant.snapshot.grasps) {
      msg::GraspState state;
      state.header = message.header;
      state.name = grasp.name;
      state.body = grasp.body;
      state.nodes.assign(grasp.nodes.begin(), grasp.nodes.end());
      state.state = static_cast<std::uint8_t>(grasp.phase);
      state.pose = to_message(grasp.world_from_grasp);
      state.wrench = wrench_message(grasp);
      state.load = grasp.load;
      message.grasps.push_back(std::move(state));
    }
    topics_[0].publish(message);
  }

 private:
  std::string frame_id_;
};

class Wrenches : public Publisher {
 public:
  explicit Wrenches(const PublisherContext& context) : context_(context), prefix_(context.node_name + "/grasp/") {}

  bool wanted() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::any_of(topics_.begin(), topics_.end(), [](const auto& entry) { return entry.second.wanted(); });
  }

  unsigned joined() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    unsigned sum = left_;
    for (const auto& [name, topic] : topics_) sum += topic.joined();
    return sum;
  }

  void update(const std::vector<std::string>& grasp_names) override {
    std::map<std::string, Topic> next;
    for (const std::string& name : grasp_names) {
      const auto known = topics_.find(name);  // only this thread changes the map
      next[name] = known != topics_.end()
                       ? known->second
                       : Topic::advertise<geometry_msgs::WrenchStamped>(context_, "grasp/" + name + "/wrench");
    }
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      topics_.swap(next);
      for (const auto& [name, topic] : next) {
        if (topics_.count(name) == 0) left_ += topic.joined();  // joined() only grows
      }
    }
  }

  void publish(const Instant& instant) override {
    for (const GraspReport& grasp : instant.snapshot.grasps) {
      Topic topic;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        const auto found = topics_.find(grasp.name);
        if (found == topics_.end() || !found->second.wanted()) continue;
        topic = found->second;
      }
      geometry_msgs::WrenchStamped message;
      message.header.frame_id = prefix_ + grasp.name;
      message.header.stamp = instant.stamp;
      message.wrench = wrench_message(grasp);
      topic.publish(message);
    }
  }

 private:
  PublisherContext context_;
  std::string prefix_;
  mutable std::mutex mutex_;
  std::map<std::string, Topic> topics_;
  unsigned left_ = 0;
};

}  // namespace

std::unique_ptr<Publisher> make_grasps_publisher(const PublisherContext& context) {
  return std::make_unique<Grasps>(context);
}

std::unique_ptr<Publisher> make_wrench_publisher(const PublisherContext& context) {
  return std::make_unique<Wrenches>(context);
}

}  // namespace deformable_sim
