// What must hold after every step of any scene.
#pragma once

#include <string>

#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim::fuzz {

/// The word and the sentence of an Outcome; no word: all is well.
struct Finding {
  std::string what, detail;
};

/// Energy. While no grasp or collider moves, nothing is commanded, no wind blows and nothing is pulled by soft grasps,
/// the sum of kinetic, elastic and potential energy E may fall, and rise only by what a scheme's error is:
///
///   E - min E <= 1/2 (K + V at the time of the minimum + m g (size + height fallen)) + 1/2 m (0.1 mm/s)^2
///
/// with the elastic energy V. Of schemes with a Jacobian E is compared without V: a stiff body gets much of that from
/// errors of position that are nothing to speak of. A scheme that diverges passes the bound in a few steps. Not looked
/// at: explicit_euler, which gains energy by its nature, and bodies that are inside a collider, which pushes them out.
class Watch {
 public:
  enum class Grasps { kRigid, kSoft };
  Watch(const SceneSpec& scene, const World& world, Grasps grasps);

  /// Something was commanded.
  void disturbed() { quiet_ = false; }
  /// After a step.
  Finding look(const World& world);
  /// The numbers alone.
  Finding look_at_numbers(const World& world) const { return look_at_numbers(world, world.snapshot()); }

 private:
  Finding look_at_numbers(const World& world, const Snapshot& now) const;
  Finding look_at_energy(const World& world, const Snapshot& now);
  Finding look_at_depth(const World& world, const Snapshot& now);
  Finding look_at_crossing(const World& world, const Snapshot& now);
  bool has_moved(const Snapshot& now);

  bool explicit_;
  bool passive_;  // energy can only fall while nothing moves
  bool quiet_ = false;
  double next_look_ = 0.0;                      // s
  double next_crossing_look_ = 0.0;             // s
  double least_ = 0.0, scale_ = 0.0, top_ = 0;  // J: of the quiet time so far
  std::vector<Pose> poses_;
  std::ptrdiff_t slipped_ = 0;  // grasps
};

}  // namespace deformable_sim::fuzz
