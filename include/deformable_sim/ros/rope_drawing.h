// Ropes and rods: a tube, and the frames of a rod with twist.
#pragma once

#include <vector>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Appends a tube of triangles around the line of a body, coloured and lit at its nodes. A rope's is carried along
/// without twist; that of a rod turns with the material, and has a darker stripe along it (lighter on a dark rod), as
/// wide as Body::stripe says, at whose middle the first director points.
void draw_tube(const Snapshot& snapshot, const Body& body, const std::vector<Eigen::Vector3f>& colors,
               visualization_msgs::Marker* marker);

/// Points and colours of a LINE_LIST: at the middle of each segment of a rod with twist the first director (red) and
/// the second (green), as long as the segment or three tube radii, whichever is more. Empty for any other body.
void draw_frames(const Snapshot& snapshot, const Body& body, visualization_msgs::Marker* marker);

}  // namespace deformable_sim
