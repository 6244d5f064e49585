// A snapshot of the world as a depth camera sees it.
#pragma once

#include "deformable_sim/core/camera/depth_buffer.h"
#include "deformable_sim/ros/camera/segment_ids.h"

namespace deformable_sim {

/// Draws all bodies, as they are shown (skins; ropes as round tubes), and all colliders and robot links.
/// world_from_camera: of the optical frame.
void draw_world(const Snapshot& snapshot, const SegmentIds::OfSnapshot& ids, const Pose& world_from_camera,
                DepthBuffer* buffer);

}  // namespace deformable_sim
