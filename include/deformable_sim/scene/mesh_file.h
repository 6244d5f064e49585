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

/// The same faces as they stand in the file, unchecked, and each axis with a scale of its own.
TriangleMesh load_faces(const std::string& path, const Vec3& scale);
/// The same of a file that is in memory; `name` tells the format by its ending, and errors name it.
TriangleMesh faces_from_bytes(const std::string& bytes, const std::string& name, const Vec3& scale);

}  // namespace deformable_sim
