// Named places of a body that pins and grasps refer to.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "deformable_sim/core/topology/polyline.h"
#include "deformable_sim/core/topology/tet_mesh.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

using Features = std::map<std::string, std::vector<int>>;

/// What a body of this kind offers, in a fixed order.
///   grid cloth  corner_0..3 at (0,0), (nx,0), (nx,ny), (0,ny); edge_k from corner_k to the next; center
///   mesh cloth  center: the node nearest to the centroid
///   open rope   end_0, end_1, center
///   closed rope end_0: the node where the loop closes; center: the one opposite
///   soft        face_x0, face_x1, face_y0 ...: all nodes on that side of its bounds at rest, in its own axes; center:
///   the
///               node nearest to the middle of the bounds; a box also corner_0..7, bit 0 of the number is x, 1 y, 2 z
std::vector<std::string> feature_names(const BodySpec& body);

/// Body-local nodes of each feature.
Features sheet_features(const TriangleMesh& mesh);
Features line_features(const Polyline& line);
enum class Corners { kNone, kOfBounds };
Features solid_features(const TetMesh& mesh, Corners corners);

}  // namespace deformable_sim
