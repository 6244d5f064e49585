// SceneSpec to a World: the only place, with registry.h, where a name becomes a type.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "deformable_sim/core/force_plugin.h"
#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/solver_choice.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Model of the scene's bodies. plugins: makes the terms of the scene's `forces` and lives as long as the model; null:
/// a scene that has forces is refused. Throws InputError naming file:line for what only the files behind it can show
/// (meshes).
std::shared_ptr<const Model> build_model(const SceneSpec& spec, std::shared_ptr<ForcePlugin> plugins = nullptr);

/// Pins, then the scene's own grasps.
std::vector<GraspRequest> grasps_of(const SceneSpec& spec);

/// What `solver: auto` chooses for the scene; `features` are features_of() it.
SolverChoice choose_for(const SceneSpec& spec, const Model& model, const SceneFeatures& features,
                        const SolverTable& table);

/// Scheme, solver and step of a world: those the scene names, or those of a choice where it has one (null: none).
WorldSettings settings_for(const SceneSpec& spec, const SolverChoice* choice);

/// Model, colliders and grasps, ready to step on so many threads. running_dt: of a world that this one is to
/// continue_from(), and so its own.
std::unique_ptr<World> build_world(const SceneSpec& spec, int threads = 1,
                                   std::shared_ptr<ForcePlugin> plugins = nullptr,
                                   std::optional<double> running_dt = {});

}  // namespace deformable_sim
