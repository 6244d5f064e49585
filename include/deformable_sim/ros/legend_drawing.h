// What the colours of bodies mean: a bar with numbers.
#pragma once

#include <string>
#include <vector>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// `legend`: an upright bar of the colours from the lowest value to the highest, which looks the same from all sides,
/// TEXT_VIEW_FACING numbers at its foot, middle and top, and above it what they are of. Empty where color_by is body.
/// Its place is outputs.legend_position, or beside the bodies as they start (least x, greatest y).
std::vector<visualization_msgs::Marker> legend_markers(const Snapshot& snapshot, const OutputSpec& outputs);

/// Three digits, with the prefix k, M or G of a unit where one is needed: "100 kPa"; 0 has no unit.
std::string number_text(double value, const std::string& unit);

/// Corners of the box around all nodes as they start, m.
std::array<Vec3, 2> starting_box(const Model& model);

}  // namespace deformable_sim
