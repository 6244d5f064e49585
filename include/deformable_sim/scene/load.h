// Scene text to a validated SceneSpec.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/scene/allowed_paths.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// A `KEY=VALUE` override: path such as bodies[0].cloth.cells, value as YAML text.
using Override = std::pair<std::string, std::string>;

/// Reads and validates a file. Throws InputError: "file:line: key: what, and what is allowed". `files` are those that
/// the scene may name: meshes, octomaps.
SceneSpec load_scene_file(const std::string& path, const std::vector<Override>& overrides = {},
                          const AllowedPaths& files = {});

/// The same for text; `origin` stands for the file name in messages and as base for relative mesh paths.
SceneSpec load_scene_text(const std::string& yaml, const std::string& origin,
                          const std::vector<Override>& overrides = {}, const AllowedPaths& files = {});

/// A bare NAME is SCENE_DIR/NAME.yaml; anything with a slash or an extension is a path. Throws InputError (kNotFound)
/// listing the scenes that exist, or what AllowedPaths throws.
std::string find_scene(const std::string& name_or_file, const std::string& scene_dir, const AllowedPaths& files = {});

/// Names of the scenes in a folder, sorted.
std::vector<std::string> scene_names(const std::string& scene_dir);

/// Where this package's config/, meshes/ ... lie: the share directory this executable was installed beside, else the
/// source tree it was built from. Also what package://deformable_sim/ stands for in a scene.
std::string package_dir();

/// DEFORMABLE_SIM_SCENES from the environment, else package_dir()/config/scenes.
std::string default_scene_dir();

/// The reference page of all keys (Markdown), generated from the same table that the loader reads with.
std::string scene_reference();

}  // namespace deformable_sim
