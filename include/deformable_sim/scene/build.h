// SceneSpec to a World: the only place, with registry.h, where a name becomes a type.
#pragma once

#include <memory>

#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Model of the scene's bodies. Throws InputError naming file:line for what only the files behind it can show (meshes).
std::shared_ptr<const Model> build_model(const SceneSpec& spec);

/// Model, colliders and grasps, ready to step on so many threads.
std::unique_ptr<World> build_world(const SceneSpec& spec, int threads = 1);

}  // namespace deformable_sim
