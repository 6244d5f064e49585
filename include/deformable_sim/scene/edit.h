// Changes of a scene that was read: the same text with something added, taken out or set, checked as the whole was.
#pragma once

#include <optional>
#include <string>

#include "deformable_sim/scene/load.h"

namespace deformable_sim {

/// `added` is a scene of its own, of which bodies, grasps and forces are taken; everything else of it is left. `pose`
/// (world from body) replaces that of its only body. Throws InputError: names that are taken (kAlreadyExists), too many
/// nodes, a pose for several bodies.
SceneSpec with_bodies(const SceneSpec& scene, const SceneSpec& added, const std::optional<Pose>& pose);

/// Without the body, and without the grasps, forces and script events that name it. Throws InputError where there is no
/// such body (kNotFound), or no other.
SceneSpec without_body(const SceneSpec& scene, const std::string& name);

/// `yaml` is what stands under `material`: the name of one of the table, or keys of which those that are given change
/// and the others stay. Throws InputError.
SceneSpec with_material(const SceneSpec& scene, const std::string& body, const std::string& yaml);

/// YAML of the scene as it is now, with overrides and changes. Throws InputError.
std::string scene_text(const SceneSpec& scene);

/// Values at their paths, as `--set` takes them. Throws InputError.
SceneSpec with_values(const SceneSpec& scene, const std::vector<Override>& values);

}  // namespace deformable_sim
