// One contact that carries a force, for people and programs.
#pragma once

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// As the last step (of its parts, the last) left it.
struct ContactReport {
  int body = 0;                 // index into Model::bodies
  int collider = -1;            // index into the world's colliders; -1: another body
  int other = -1;               // that body (the same where it touches itself); -1: a collider
  Vec3 point = Vec3::Zero();    // m, world: on the surface of the collider; between bodies on that of `body`
  Vec3 normal = Vec3::UnitZ();  // out of the collider
  Vec3 force = Vec3::Zero();    // N on the body; the collider feels the opposite
  double distance = 0.0;  // m between the surfaces of collider and body (contact radius); negative where they overlap
};

}  // namespace deformable_sim
