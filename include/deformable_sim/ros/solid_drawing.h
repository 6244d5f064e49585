// Soft bodies: smooth where they are round, sharp along their edges.
#pragma once

#include <vector>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

/// Appends the triangles of a surface at x, coloured by the points' colours. Each corner of a face is lit by the mean
/// normal, weighted by area, of the faces around the point that are turned against it by less than 40 degrees.
void draw_solid(const TriangleMesh& surface, const ShownColumns& x, const std::vector<Eigen::Vector3f>& colors,
                visualization_msgs::Marker* marker);

}  // namespace deformable_sim
