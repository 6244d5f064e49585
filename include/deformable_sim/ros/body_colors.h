// Colours that tell strain, stress, speed or contact.
#pragma once

#include <vector>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Unlit colour, rgb 0 ... 1.
using Color = Eigen::Vector3f;

/// Of each point shown of a body (shown_body.h), by outputs.color_by:
///
///   body      its own colour
///   strain    blue at -strain_range, grey at 0, red at strain_range; magenta where an edge at the node is outside
///             Body::valid_strain, the range in which the material's law holds
///   stress    likewise over stress_range; red and positive for von Mises. A body whose model has no stress: grey
///   velocity  red at 1 m/s
///   contact   red at twice the mean force of the touching nodes
std::vector<Color> body_colors(const Snapshot& snapshot, const Body& body, const OutputSpec& outputs);

}  // namespace deformable_sim
