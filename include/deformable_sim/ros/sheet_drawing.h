// Cloth: one smooth face, or what its look asks for: squares, seams, two faces.
#pragma once

#include <vector>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

/// Whether squares and seams are shown. They would be mistaken for values where colours tell some.
enum class Painting { kShown, kHidden };

/// Appends the triangles of a cloth, coloured by its points' colours and lit by their normals, alike on both sides.
/// With a thickness (SheetLook) there are two faces, half of it along the normals to either side, and a strip between
/// them along the borders.
void draw_sheet(const Snapshot& snapshot, const Body& body, std::vector<Eigen::Vector3f> colors, Painting painting,
                visualization_msgs::Marker* marker);

}  // namespace deformable_sim
