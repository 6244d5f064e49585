// ~contacts and ~contact/<collider>/wrench.
#include <algorithm>
#include <utility>

#include <geometry_msgs/WrenchStamped.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/publishers/named_topics.h"
#include "deformable_sim/ros/state_messages.h"

namespace deformable_sim {

namespace {

class Contacts : public TopicsPublisher {
 public:
  explicit Contacts(const PublisherContext& context) : frame_id_(context.frame_id) {
    topics_.push_back(Topic::advertise<msg::ContactArray>(context, "contacts"));
  }

  bool shows_contacts() const override { return true; }

  void publish(const Instant& instant) override {
    msg::ContactArray message;
    message.header.frame_id = frame_id_;
    message.header.stamp = instant.stamp;
    message.contacts = contact_messages(instant.snapshot);
    topics_[0].publish(std::move(message));
  }

 private:
  std::string frame_id_;
};

/// Names of robot links hold a dot, which topics may not.
std::string topic_of(std::string collider) {
  std::replace(collider.begin(), collider.end(), '.', '/');
  return "contact/" + collider + "/wrench";
}

class ContactWrenches : public Publisher {
 public:
  explicit ContactWrenches(const PublisherContext& context) : context_(context) {}

  bool wanted() const override { return topics_.wanted(); }
  unsigned joined() const override { return topics_.joined(); }
  bool shows_contacts() const override { return true; }

  void update(const TopicNames& names) override {
    topics_.update<geometry_msgs::WrenchStamped>(context_, names.attached_colliders, topic_of);
  }

  void publish(const Instant& instant) override {
    const std::vector<Collider>& colliders = instant.snapshot.colliders;
    for (std::size_t i = 0; i < colliders.size(); ++i) {
      const auto topic = topics_.find_wanted(colliders[i].name);
      if (topic) topic->publish(message(instant, static_cast<int>(i)));
    }
  }

 private:
  static geometry_msgs::WrenchStamped message(const Instant& instant, int index) {
    const Collider& collider = instant.snapshot.colliders[static_cast<std::size_t>(index)];
    const Pose world_from_frame = collider.world_from_collider * collider.frame_from_collider.inverse();
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const ContactReport& c : instant.snapshot.contacts) {
      if (c.collider != index) continue;
      force -= c.force;
      torque -= (c.point - world_from_frame.translation()).cross(c.force);
    }
    const Mat3 frame_from_world = world_from_frame.linear().transpose();
    geometry_msgs::WrenchStamped message;
    message.header.frame_id = collider.frame;
    message.header.stamp = instant.stamp;
    message.wrench.force = to_vector(frame_from_world * force);
    message.wrench.torque = to_vector(frame_from_world * torque);
    return message;
  }

  PublisherContext context_;
  NamedTopics topics_;
};

}  // namespace

std::unique_ptr<Publisher> make_contacts_publisher(const PublisherContext& context) {
  return std::make_unique<Contacts>(context);
}

std::unique_ptr<Publisher> make_contact_wrench_publisher(const PublisherContext& context) {
  return std::make_unique<ContactWrenches>(context);
}

}  // namespace deformable_sim
