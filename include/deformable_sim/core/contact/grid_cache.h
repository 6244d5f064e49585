// Distance grids of meshes kept on disk, under the content of the mesh.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/distance_grid.h"
#include "deformable_sim/core/contact/solid_parts.h"

namespace deformable_sim {

/// FNV-1a, 64 bits, of vertices and triangles, and of what the grid is laid out by.
std::uint64_t content_hash(const SolidPart& part);

/// Fills the values of a grid that is laid out already. False, and nothing is changed, when the folder holds no file
/// for this hash, or one that is broken, of another layout or another byte order.
bool read_grid(const std::string& folder, std::uint64_t hash, DistanceGrid* grid);

/// Makes the folder if need be. The file appears whole or not at all, whoever else writes the same; where none can be
/// written, none is: the grid is built anew next time.
void write_grid(const std::string& folder, std::uint64_t hash, const DistanceGrid& grid);

}  // namespace deformable_sim
