#include "deformable_sim/ros/transforms.h"

#include <ros/console.h>

#include "deformable_sim/ros/careful_messages.h"
#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

constexpr int kQueue = 100;
constexpr int kEnough = 3;  // too old in a row: one or two may be stragglers of another publisher
constexpr std::size_t kMostFrames = 10000;
constexpr std::uint32_t kLatest =
    0xFFFFFFFFu - 1000u;  // s: a buffer adds what it keeps to a stamp, and ros::Time throws

}  // namespace

Transforms::Transforms() : spinner_(1, &queue_) {
  nh_.setCallbackQueue(&queue_);
  auto moving = careful_subscription<tf2_msgs::TFMessage>(
      "/tf", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) { hear(*message, false); });
  auto fixed = careful_subscription<tf2_msgs::TFMessage>(
      "/tf_static", kQueue, [this](const tf2_msgs::TFMessageConstPtr& message) { hear(*message, true); });
  moving_ = nh_.subscribe(moving);
  static_ = nh_.subscribe(fixed);
  spinner_.start();
}

void Transforms::forget() {
  const std::lock_guard<std::mutex> lock(mutex_);
  clear();
}

void Transforms::clear() {
  buffer_.clear();
  newest_.clear();
}

void Transforms::hear(const tf2_msgs::TFMessage& message, bool is_static) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const ros::Time now = ros::Time::now();
  if (now < heard_) clear();
  heard_ = now;
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    if (transform.header.stamp.sec > kLatest) {
      ROS_WARN_STREAM_THROTTLE_NAMED(10.0, "frames",
                                     "a transform of tf frame " << printable(transform.child_frame_id)
                                                                << " is dropped: its stamp is the end of time");
      continue;
    }
    if (!is_static && is_set_back(transform)) {
      ROS_WARN_STREAM_THROTTLE_NAMED(10.0, "frames",
                                     "the clock of tf frame " << printable(transform.child_frame_id)
                                                              << " was set back to " << transform.header.stamp
                                                              << "; what is older is dropped");
      clear();
    }
    buffer_.setTransform(transform, "tf", is_static);
  }
}

/// Whether the frame's last transforms were all older than what the buffer takes.
bool Transforms::is_set_back(const geometry_msgs::TransformStamped& transform) {
  if (newest_.size() > kMostFrames) newest_.clear();
  Newest& newest = newest_[transform.child_frame_id];
  const ros::Time stamp = transform.header.stamp;
  // Times that others say need not bear a sum.
  if (newest.stamp.toSec() - stamp.toSec() > buffer_.getCacheLength().toSec()) return ++newest.too_old >= kEnough;
  newest.too_old = 0;
  if (stamp > newest.stamp) newest.stamp = stamp;
  return false;
}

}  // namespace deformable_sim
