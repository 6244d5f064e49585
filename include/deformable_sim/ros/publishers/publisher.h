// What all output topics have in common: nothing is built for a topic that nobody listens to.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <geometry_msgs/PoseStamped.h>
#include <ros/node_handle.h>
#include <boost/make_shared.hpp>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/ros/advertiser.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

class Frames;
class Warnings;

/// One state of the world and of its run, immutable, shown by all publishers with one stamp.
struct Instant {
  Snapshot snapshot;
  ros::Time stamp;
  bool paused = false;
  std::string failure;             // why the simulation stopped; empty while it is well
  bool behind = false;             // real time is not held
  double real_time_factor = 0.0;   // 0 = not measured yet
  double mean_step_seconds = 0.0;  // wall s
  double longest_step_seconds = 0.0;
  std::vector<std::string> warnings;  // the core's and the node's
};

/// What publishers of one scene are made from.
struct PublisherContext {
  ros::NodeHandle private_nh;
  Advertiser advertiser;
  std::string frame_id;   // of all messages
  std::string node_name;  // without leading slash; prefix of tf frames
  std::shared_ptr<const Model> model;
  ros::Time loaded;  // stamp of what is published once per scene
  OutputSpec outputs;
  const Frames* frames = nullptr;
  Warnings* warnings = nullptr;
  /// A person drags the handle of a grasp.
  std::function<void(const std::string& grasp, const geometry_msgs::PoseStamped& target)> drag_grasp;
};

/// A topic that counts who comes, so that a paused simulation can be shown to a newcomer.
class Topic {
 public:
  template <typename Message>
  static Topic advertise(const PublisherContext& context, const std::string& name) {
    Topic topic;
    topic.publisher_ = context.advertiser.make([&] {
      ros::NodeHandle nh = context.private_nh;
      return std::make_unique<ros::Publisher>(nh.advertise<Message>(
          name, 1, [joined = topic.joined_](const ros::SingleSubscriberPublisher&) { ++*joined; }));
    });
    return topic;
  }
  bool wanted() const { return publisher_->getNumSubscribers() > 0; }
  unsigned joined() const { return *joined_; }
  /// Subscribers of the same process get this very message, without a copy.
  template <typename Message>
  void publish(Message message) const {
    publisher_->publish(boost::make_shared<const Message>(std::move(message)));
  }

 private:
  std::shared_ptr<std::atomic<unsigned>> joined_ = std::make_shared<std::atomic<unsigned>>(0);
  std::shared_ptr<ros::Publisher> publisher_;
};

/// What comes and goes and has topics of its own.
struct TopicNames {
  std::vector<std::string> grasps;
  std::vector<std::string> attached_colliders;  // also those whose frame has not been seen yet
};

/// One kind of output. wanted() and joined() are asked on the simulation thread, publish() is called on the publishing
/// thread, update() on the thread that keeps topics.
class Publisher {
 public:
  virtual ~Publisher() = default;
  virtual bool wanted() const = 0;
  /// Grows whenever a subscriber comes.
  virtual unsigned joined() const = 0;
  virtual void publish(const Instant& instant) = 0;
  /// What it shows of a snapshot; the same at any time.
  virtual SnapshotDetail detail() const { return SnapshotDetail::kMotion; }
  /// Whether it shows Snapshot::contacts; the same at any time.
  virtual bool shows_contacts() const { return false; }
  /// Something came or went.
  virtual void update(const TopicNames& /*names*/) {}
};

/// The usual publisher: a fixed list of topics.
class TopicsPublisher : public Publisher {
 public:
  bool wanted() const override {
    for (const Topic& topic : topics_) {
      if (topic.wanted()) return true;
    }
    return false;
  }
  unsigned joined() const override {
    unsigned sum = 0;
    for (const Topic& topic : topics_) sum += topic.joined();
    return sum;
  }

 protected:
  std::vector<Topic> topics_;
};

}  // namespace deformable_sim
