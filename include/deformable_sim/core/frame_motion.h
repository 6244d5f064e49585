// A frame on its way to a target: straight and slerped, in a given time, never faster than a limit.
#pragma once

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Motion of a grasp or a collider. At rest until move_to().
class FrameMotion {
 public:
  explicit FrameMotion(const Pose& pose) : pose_(pose), start_(pose), target_(pose) {}

  /// Reaches `target` `duration` s from now, or as fast as the limit allows when duration is 0.
  void move_to(const Pose& target, double duration);
  /// Stays where it is and forgets its target.
  void stop();

  /// Moves on by dt (s). No point within `lever` (m) of the frame's origin travels further than max_speed * dt.
  /// Returns false when that limit held the frame back.
  bool advance(double dt, double max_speed, double lever);

  /// Saved states.
  void pass(Archive* archive);

  const Pose& pose() const { return pose_; }
  const Pose& target() const { return target_; }
  bool moving() const { return moving_; }

  /// Longest way of a point within `lever` of the origin from one pose to the other, straight and slerped, m.
  static double travel(const Pose& from, const Pose& to, double lever);

 private:
  Pose pose_, start_, target_;
  double duration_ = 0.0, elapsed_ = 0.0;
  bool moving_ = false;
};

/// True when every entry is finite, the position is within 1e6 m and the rotation is a rotation (within 1e-6).
bool is_valid_pose(const Pose& pose);

}  // namespace deformable_sim
