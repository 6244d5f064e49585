// Point clouds of bodies: x y z, normal_x normal_y normal_z, vx vy vz, strain (float32), node [, body] (uint32).
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// 44 B a point; organised (height = rows, width = columns) for a grid cloth, otherwise one row. The points are the
/// nodes, or the vertices of the body's skin; `node` is the nearest node. Normals are zero for a rope and inside a soft
/// body.
sensor_msgs::PointCloud2 body_cloud(const Snapshot& snapshot, int body);

/// All bodies in one row, 48 B a point: `node` counts in the body, `body` is its place in the scene.
sensor_msgs::PointCloud2 world_cloud(const Snapshot& snapshot);

}  // namespace deformable_sim
