// Colliders and grasps as rviz markers.
#pragma once

#include <array>
#include <vector>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Edge of the square (m) by which a plane is drawn.
constexpr double kPlaneSize = 10.0;

/// Of letters: read on a dark background, rviz's own, and on a light one.
constexpr std::array<float, 3> kLetterColor{{0.80f, 0.42f, 0.05f}};

/// One marker a shape, three a capsule; a plane is a thin slab of 10 m under its surface. Ids count from 0.
std::vector<visualization_msgs::Marker> collider_markers(const Collider& collider);

/// A ball, green while it holds, orange while it waits for its frame, red when it slipped, and its name above.
std::vector<visualization_msgs::Marker> grasp_markers(const GraspReport& grasp);

}  // namespace deformable_sim
