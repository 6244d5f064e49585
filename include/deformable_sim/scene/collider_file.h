// Shapes of colliders from mesh files.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/contact/collider.h"
#include "deformable_sim/core/contact/distance_grid.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// $XDG_CACHE_HOME/deformable_sim, else ~/.cache/deformable_sim, else empty: no cache.
std::string cache_folder();

/// A shape for each closed part of the mesh; `padding` (m, >= 0) moves the surface outwards. Distance grids are taken
/// from the cache, and kept there. Throws InputError (split_into_solids()).
std::vector<Shape> mesh_shapes(const TriangleMesh& mesh, double padding, const DistanceGrid::Progress& progress);

/// The same from an OBJ, STL, PLY or DAE file (load_faces()). The error names the file.
std::vector<Shape> load_collider_mesh(const std::string& path, const Vec3& scale, double padding,
                                      const DistanceGrid::Progress& progress);

}  // namespace deformable_sim
