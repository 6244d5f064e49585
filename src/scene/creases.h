// Fold lines of a scene as edges of a mesh.
#pragma once

#include <vector>

#include "deformable_sim/core/material/bending_law.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Interior edges that lie on the lines, seen along z of the rest mesh. Throws PlacedError where a
/// line runs beside the edges or off the sheet.
std::vector<Crease> find_creases(const TriangleMesh& mesh, const std::vector<CreaseSpec>& lines);

}  // namespace deformable_sim
