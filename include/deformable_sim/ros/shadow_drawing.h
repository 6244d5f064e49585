// Shadows of bodies on what lies flat under them.
#pragma once

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Shadows hover this far (m) over what they fall on, so that both are told apart.
constexpr double kShadowLift = 5e-4;

/// Dark, translucent TRIANGLE_LIST: what is seen of a body along gravity, on planes (as large as they are drawn) and
/// tops of boxes within 1 degree of horizontal, each part on the highest of them below it. Of a cloth all triangles, so
/// that layers add up; of a soft body those that face up; of a rope a band as wide. No points without gravity. Links of
/// a robot, which rviz draws itself, are passed through.
visualization_msgs::Marker shadow_marker(const Snapshot& snapshot, int body);

}  // namespace deformable_sim
