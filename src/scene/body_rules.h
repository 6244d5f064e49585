// What no single key of a body can tell: which keys belong together.
#pragma once

#include <string>

#include "deformable_sim/scene/spec.h"
#include "yaml_value.h"

namespace deformable_sim {

/// Throws InputError "file:line: path: what" for keys of `entry`, the map that `body` was read from, that contradict
/// each other.
void check_body_keys(const YamlValue& entry, const std::string& path, const BodySpec& body);

/// Nodes that the keys alone ask for; 0 for meshes.
double expected_nodes(const BodySpec& body);

/// Vertices of the visual surface that the keys alone ask for; 0 for meshes.
double expected_skin_vertices(const BodySpec& body);

}  // namespace deformable_sim
