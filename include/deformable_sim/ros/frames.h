// tf, seen from the simulation. The listener exists from the first question on: a scene without tf has none.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <ros/time.h>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

class Transforms;

/// Newest known pose of a frame. stamp zero = static.
struct FramePose {
  Pose world_from_frame;
  ros::Time stamp;
};

/// Thread safe. Always the newest transform is used, whatever stamp a request carries: targets mean "now".
class Frames {
 public:
  /// timeout in s.
  Frames(std::string world_frame, double timeout);
  ~Frames();

  /// Starts listening (network, so not on the simulation thread).
  void open();

  /// Waits until the transform is there. Throws InputError (kUnavailable) naming the frame after the timeout; just
  /// after open() up to 1 s more, as connections take that long. Empty = the world frame.
  Pose resolve(const std::string& frame);

  /// Does not wait; nothing when the frame is not connected to the world frame or open() was not called.
  std::optional<FramePose> latest(const std::string& frame) const;

  /// Drops moving transforms: stamps of this node's own frames are about to begin anew.
  void forget();

  const std::string& world_frame() const { return world_frame_; }
  double timeout() const { return timeout_; }

 private:
  std::string world_frame_;
  double timeout_;
  std::mutex opening_;
  std::atomic<bool> listening_{false};
  std::unique_ptr<Transforms> listener_;
  std::chrono::steady_clock::time_point opened_at_;
};

}  // namespace deformable_sim
