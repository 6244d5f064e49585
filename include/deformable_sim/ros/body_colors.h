// Colours that tell strain, stress, speed or contact.
#pragma once

#include <string>
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
///   contact   red at twice the mean force of the touching nodes of all bodies
std::vector<Color> body_colors(const Snapshot& snapshot, const Body& body, const OutputSpec& outputs);

/// What color_by shows, and the values at grey (or blue) and at red. Without a quantity: the bodies' own colours.
struct ColorScale {
  std::string quantity, unit;
  double low = 0.0, high = 0.0;  // in the unit; low = -high where there is blue, else 0
};
ColorScale color_scale(const Snapshot& snapshot, const OutputSpec& outputs);

/// Blue at -1, grey at 0, red at 1 and beyond.
Color scale_color(float value);

}  // namespace deformable_sim
