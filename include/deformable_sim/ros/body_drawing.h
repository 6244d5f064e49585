// Bodies as rviz markers: triangles with the light already in their colours.
#pragma once

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// rviz complains about a quaternion of zeros, which is what a marker starts with.
visualization_msgs::Marker blank_marker();

/// TRIANGLE_LIST of a body. rviz gives each triangle one normal and does not light a list that has colours, so the
/// light is computed here at the nodes: smooth, and the same from both sides. A cloth is its triangles, a rope a tube.
/// Coloured by outputs.color_by: body, strain (blue compressed, red stretched by strain_range), velocity (red at 1
/// m/s), contact (red at twice the mean force of the touching nodes).
visualization_msgs::Marker body_marker(const Snapshot& snapshot, int body, const OutputSpec& outputs);

/// LINE_LIST of the structural edges of a body.
visualization_msgs::Marker wireframe_marker(const Snapshot& snapshot, int body);

}  // namespace deformable_sim
