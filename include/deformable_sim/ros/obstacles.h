// Obstacle messages to colliders, frames resolved.
#pragma once

#include <optional>

#include "deformable_sim/core/command.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/scene/allowed_paths.h"

namespace deformable_sim {

struct ObstacleRequest {
  Collider collider;                        // where it is now
  std::optional<Pose> frame_from_collider;  // set: it moves with collider.frame
};

/// Of an ADD; `files` are those it may name. Throws InputError: name, no shape, wrong dimensions, more than 1000
/// shapes, meshes (kUnavailable), files, frames.
ObstacleRequest to_obstacle(const msg::Obstacle& message, const AllowedPaths& files, Frames* frames);

/// Of a MOVE. Throws InputError.
command::MoveCollider to_obstacle_move(const msg::Obstacle& message, Frames* frames);

}  // namespace deformable_sim
