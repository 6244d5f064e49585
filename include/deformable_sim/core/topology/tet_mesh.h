// A volume of tetrahedra at rest: connectivity and rest positions, immutable once built.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Linear tetrahedra {a, b, c, d} with (b - a) x (c - a) . (d - a) > 0. Quadratic ones keep six more nodes each, in the
/// middle of the edges ab, bc, ca, ad, bd, cd.
struct TetMesh {
  Nodes rest;                                 // 3 x n, m
  std::vector<std::array<int, 4>> tets;       // corners
  std::vector<std::array<int, 6>> mid_nodes;  // parallel to tets; empty: linear
  bool is_quadratic() const { return !mid_nodes.empty(); }
};

/// Box centred on the origin, nodes row by row: x fastest, then y, then z. Each cell is cut into six tetrahedra around
/// one of its diagonals [Kuhn 1960], mirrored from cell to cell so that they fit and no direction is preferred.
/// size > 0 (m), cells >= 1, along x, y, z. Throws InputError.
TetMesh make_box(const Vec3& size, const std::array<int, 3>& cells);

/// The cubes of edge `cell` (m) that a closed surface cuts or encloses, cut like those of make_box; the grid is centred
/// on the bounds of the surface. Cubes that would hang together by an edge or a corner only are joined by filling
/// in. Parts of the surface closer than about a cell grow together. Throws InputError when the surface is not closed
/// or takes more than ten million cells.
TetMesh make_lattice_around(const TriangleMesh& surface, double cell);

/// The same mesh with quadratic elements: a node more in the middle of each edge, behind those there were.
TetMesh with_mid_nodes(const TetMesh& mesh);

/// The surface, wound so that normals point outwards; all nodes of the volume are there under the same indices, those
/// inside are in no triangle. A face of a quadratic element becomes four triangles.
TriangleMesh boundary_of(const TetMesh& mesh);

/// Throws InputError naming the offending element or node: index out of range, repeated node, volume not positive or
/// vanishing (six times the volume below 1e-9 of the longest edge cubed), a node that is not finite, unused, or not in
/// the middle of its edge, middle nodes that differ between neighbours.
void check_mesh(const TetMesh& mesh);

/// Rest volume of one tetrahedron, m^3.
double volume_of(const TetMesh& mesh, size_t tet);

}  // namespace deformable_sim
