// Triangle meshes from files.
#pragma once

#include <string>

#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// Reads OBJ, STL, PLY or DAE. All parts of the file make one mesh; polygons are cut into triangles; vertices at
/// exactly the same place become one node; nodes are numbered in the order in which the faces first name them. `scale`
/// is metres per unit of the file; a DAE file's own unit is applied first, its up axis is not: coordinates are taken as
/// they stand. Coordinates pass through single precision (relative 6e-8). Throws InputError naming the file: missing,
/// unreadable, without faces, or refused by check_mesh().
TriangleMesh load_mesh(const std::string& path, double scale);

}  // namespace deformable_sim
