// Smooth upsampling of grids: a bicubic surface through the nodes, sampled more finely.
#pragma once

#include "deformable_sim/core/topology/embedding.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// Most vertices a cell is cut into along one side.
constexpr int kMaxUpsampling = 32;

/// Weights of the points of a grid `factor` times as fine as the given one, on the tensor product of Catmull-Rom
/// splines through its nodes [Catmull 1974]; of (rows - 1) factor + 1 rows and (cols - 1) factor + 1 columns,
/// numbered row by row.
///
///   y(t) = 1/2 [1 t t^2 t^3] [0 2 0 0; -1 0 1 0; 2 -5 4 -1; -1 3 -3 1] [x_-1 x_0 x_1 x_2]^T,  0 <= t <= 1
///
/// The node missing beyond the rim is extrapolated by the parabola through the last three (by the line through the last
/// two where there are no more). Interpolates the nodes, is continuous with its tangents, and reproduces quadratic
/// functions of row and column everywhere, planes where a side has only two nodes. Not monotone: along a row it
/// overshoots the four nodes around it by up to 1/8 of their range. Throws InputError when the mesh is no grid or
/// factor is not in 1 ... kMaxUpsampling.
Embedding upsample(const TriangleMesh& grid, int factor);

}  // namespace deformable_sim
