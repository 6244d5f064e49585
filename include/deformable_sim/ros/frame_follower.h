// What tf moves: grasps that follow a frame, obstacles attached to one, links of the robot.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <ros/time.h>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/world.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/warnings.h"

namespace deformable_sim {

/// Asked before every step on the simulation thread, where all of it lives. A new transform becomes a move that takes
/// as long as transforms are apart, so that a 50 Hz tf drives a 200 Hz simulation smoothly, at the price of lagging one
/// period. A frame that stops arriving leaves its grasps and colliders standing still; grasps report so.
class FrameFollower {
  using Clock = std::chrono::steady_clock;
  struct Follower;

 public:
  FrameFollower(const Frames& frames, Warnings* warnings);

  /// Begins anew with a world just built or reset. `attached` are colliders given relative to their frame (pose =
  /// frame_from_collider), put into the world when the frame is first seen.
  void begin(const std::vector<Collider>& attached, const std::vector<GraspReport>& grasps);
  /// A command that the world accepted: begin or stop following what it names.
  void applied(const Command& command);
  /// The bodies have changed, and with them the grasps there are.
  void keep(const std::vector<GraspReport>& grasps);
  /// frame_from_collider of a collider that `applied` is about to see with a frame.
  void attach(const Collider& collider, const Pose& frame_from_collider);
  /// The frame that moves a grasp or a collider; empty when none does.
  std::string frame_of(const std::string& name) const;
  /// Names of the colliders that frames move.
  std::vector<std::string> colliders() const;
  void update(World* world);

  /// What is followed, for saved states; transforms come anew from tf.
  std::string save() const;
  /// What save() has written, empty: nothing; `attached` as in begin(). Throws InputError.
  std::vector<Follower> read(const std::string& bytes, const std::vector<Collider>& attached) const;
  void go_on_with(std::vector<Follower> followers);

 private:
  enum class Kind { kGrasp, kCollider };

  struct Follower {
    Kind kind = Kind::kGrasp;
    std::string name;
    std::string frame;
    std::optional<Pose> frame_from_part;  // unset: a grasp of the scene, as it lies when the frame is first seen
    Pose world_from_part = Pose::Identity();
    std::optional<Collider> absent;  // not in the world yet
    FramePose last;
    bool seen = false;
    bool waiting = false;
    double seen_at = 0.0;  // simulated s
    Clock::time_point seen_at_wall;
    double period = 0.0;  // s between transforms, simulated
  };

  void pass(Archive* archive, const std::vector<Collider>& attached, std::vector<Follower>* followers) const;
  void take(const FramePose& pose, World* world, Follower* follower);
  void check_age(World* world, Follower* follower);
  void set_waiting(World* world, Follower* follower, bool waiting);
  void report_unseen();
  void remove(Kind kind, const std::string& name);  // name empty = all

  const Frames& frames_;
  Warnings* warnings_;
  std::vector<Follower> followers_;
  std::string unseen_;
};

}  // namespace deformable_sim
