// Bodies as rviz markers: triangles with the light already in their colours.
#pragma once

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// rviz complains about a quaternion of zeros, which is what a marker starts with.
visualization_msgs::Marker blank_marker();

/// TRIANGLE_LIST of a body. rviz gives each triangle one normal and does not light a list that has colours, so the
/// light is computed here at the points: smooth, and the same from both sides; the edges of a soft body stay sharp. A
/// cloth or soft body is its surface, or its skin's; a rope is a tube. Coloured as body_colors.h says.
visualization_msgs::Marker body_marker(const Snapshot& snapshot, int body, const OutputSpec& outputs);

/// LINE_LIST of the structural edges of a body: always of the nodes that are simulated.
visualization_msgs::Marker wireframe_marker(const Snapshot& snapshot, int body);

/// LINE_LIST of the two material directors of each segment of a rod with twist; no points for any other body.
visualization_msgs::Marker frames_marker(const Snapshot& snapshot, int body);

}  // namespace deformable_sim
