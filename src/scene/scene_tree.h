// A scene's text as a tree, read into a SceneSpec.
#pragma once

#include <string>

#include "deformable_sim/scene/load.h"
#include "yaml_value.h"

namespace deformable_sim {

/// load_scene_text() after parsing and overrides.
SceneSpec load_scene_tree(YamlValue root, const std::string& origin, const AllowedPaths& files);

}  // namespace deformable_sim
