// What is heard on /tf, and the clock of those who say it set back.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

namespace deformable_sim {

/// Listens from its construction on, on a thread of its own. As tf2_ros::TransformListener, but for clocks that are not
/// this process's ROS time: a buffer takes nothing that is 10 s older than the newest it has of a frame, so that a
/// simulation that was reset would not see its robot again until it is as old as it was. To clear the buffer with the
/// reset is not enough: what is under way then arrives after it.
class Transforms {
 public:
  Transforms();

  tf2::BufferCore& buffer() { return buffer_; }
  /// Drops all that is not static.
  void forget();

 private:
  struct Newest {
    ros::Time stamp;
    int too_old = 0;  // in a row
  };

  void clear();
  void hear(const tf2_msgs::TFMessage& message, bool is_static);
  bool is_set_back(const geometry_msgs::TransformStamped& transform);

  tf2::BufferCore buffer_;
  std::mutex mutex_;
  std::map<std::string, Newest> newest_;  // by frame
  ros::Time heard_;                       // last
  ros::NodeHandle nh_;
  ros::CallbackQueue queue_;
  ros::Subscriber moving_, static_;
  ros::AsyncSpinner spinner_;
};

}  // namespace deformable_sim
