// The world's colliders and their motion.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/frame_motion.h"

namespace deformable_sim {

/// Where a collider is when a step begins and when it ends.
struct PoseStep {
  Pose begin = Pose::Identity();
  Pose end = Pose::Identity();
};

class ColliderSet {
 public:
  /// max_speed in m/s: of any point of a collider (planes: of points within 1 m of the collider's origin).
  explicit ColliderSet(double max_speed) : max_speed_(max_speed) {}

  /// Throws InputError on an invalid collider or a name in use.
  void add(const Collider& collider);
  /// Throws InputError (kNotFound) naming those that exist.
  void remove(const std::string& name);
  /// Throws InputError (kNotFound).
  void let_through(const std::string& name, std::vector<std::string> bodies);
  /// Throws InputError. Returns a note when max_speed does not allow that duration (or one step of dt); otherwise
  /// empty.
  std::string move(const std::string& name, const Pose& target, double duration, double dt);

  /// Moves on by dt and fills `steps`, one a collider.
  void advance(double dt, std::vector<PoseStep>* steps);

  bool empty() const { return colliders_.empty(); }
  /// Poses are those of now.
  const std::vector<Collider>& colliders() const { return colliders_; }

  /// Saved states. Meshes and octomaps that `known` has as well are taken from there instead of being built anew.
  void pass(const std::vector<Collider>& known, Archive* archive);

  /// Motions only, for repeating a step.
  const std::vector<FrameMotion>& motions() const { return motions_; }
  void restore_motions(const std::vector<FrameMotion>& motions);

 private:
  size_t find(const std::string& name) const;

  double max_speed_;
  std::vector<Collider> colliders_;
  std::vector<FrameMotion> motions_;
  std::vector<double> levers_;
};

/// In saved states and recorded commands; `known` as for ColliderSet::pass(). It is not checked.
void pass_collider(const std::vector<Collider>& known, Archive* archive, Collider* collider);

}  // namespace deformable_sim
