// ~grasps and ~grasp/<name>/wrench.
#include <geometry_msgs/WrenchStamped.h>
#include <utility>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/publishers/named_topics.h"
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
    message.grasps = grasp_state_messages(instant.snapshot, frame_id_, instant.stamp);
    topics_[0].publish(std::move(message));
  }

 private:
  std::string frame_id_;
};

class Wrenches : public Publisher {
 public:
  explicit Wrenches(const PublisherContext& context) : context_(context), prefix_(context.node_name + "/grasp/") {}

  bool wanted() const override { return topics_.wanted(); }
  unsigned joined() const override { return topics_.joined(); }

  void update(const TopicNames& names) override {
    topics_.update<geometry_msgs::WrenchStamped>(context_, names.grasps,
                                                 [](const std::string& name) { return "grasp/" + name + "/wrench"; });
  }

  void publish(const Instant& instant) override {
    for (const GraspReport& grasp : instant.snapshot.grasps) {
      const auto topic = topics_.find_wanted(grasp.name);
      if (!topic) continue;
      geometry_msgs::WrenchStamped message;
      message.header.frame_id = prefix_ + grasp.name;
      message.header.stamp = instant.stamp;
      message.wrench = wrench_message(grasp);
      topic->publish(std::move(message));
    }
  }

 private:
  PublisherContext context_;
  std::string prefix_;
  NamedTopics topics_;
};

}  // namespace

std::unique_ptr<Publisher> make_grasps_publisher(const PublisherContext& context) {
  return std::make_unique<Grasps>(context);
}

std::unique_ptr<Publisher> make_wrench_publisher(const PublisherContext& context) {
  return std::make_unique<Wrenches>(context);
}

}  // namespace deformable_sim
