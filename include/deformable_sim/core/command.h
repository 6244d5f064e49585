// Everything that may change a running world from outside, applied between steps in arrival order.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/grasp.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

namespace command {

struct Grasp {
  GraspRequest request;
};
/// New target of a grasp. The grasp moves there in `duration` s (0 = as fast as max_speed allows), straight and
/// slerped.
struct MoveGrasp {
  std::string name;
  Pose world_from_target = Pose::Identity();
  double duration = 0.0;
};
/// Marks a grasp as waiting for its frame (it holds still) or following again.
struct SetGraspWaiting {
  std::string name;
  bool waiting = false;
};
struct Release {
  std::string name;  // empty = all
};
struct AddCollider {
  Collider collider;
};
/// The collider reaches the pose in `duration` s (0 = within the next step).
struct MoveCollider {
  std::string name;
  Pose world_from_collider = Pose::Identity();
  double duration = 0.0;
};
struct RemoveCollider {
  std::string name;
};
/// The bodies that the collider does not touch from now on; none: it touches all. Where one is in it then, it is let
/// out softly.
struct LetThrough {
  std::string name;
  std::vector<std::string> bodies;
};
/// Positions and velocities of one body, exact, but that nodes beyond strain limits are moved to the nearest place
/// within them, which the note says. Refused where the body would cross itself or another that it may touch. A rod with
/// twist also has the angles and frames of its segments: given in `rod` as rod_state() wrote them, exact as well; left
/// out, the angles stay and the frames are carried along to the new positions without spin.
struct SetBodyState {
  std::string body;
  Nodes x, v;
  RodState rod = {};
};
/// Back to the initial state, grasps and colliders of the scene.
struct Reset {};

}  // namespace command

using Command = std::variant<command::Grasp, command::MoveGrasp, command::SetGraspWaiting, command::Release,
                             command::AddCollider, command::MoveCollider, command::RemoveCollider, command::LetThrough,
                             command::SetBodyState, command::Reset>;

struct Reply {
  Status status;
  std::vector<int> nodes;  // of a grasp, body-local
  std::string note;        // accepted, but the caller should know (for example: the jump is limited to max_speed)
};

}  // namespace deformable_sim
