// A triangulated sheet at rest: connectivity and rest positions, immutable once built.
#pragma once

#include <array>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

struct TriangleMesh {
  Nodes rest;                                 // 3 x n, m
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from the outer side
  int rows = 0;                               // nodes per column of a grid; 0 when not a grid
  int cols = 0;                               // nodes per row of a grid; node = row * cols + col
  bool is_grid() const { return rows > 0; }
};

/// Grid in the x-y plane centred on the origin, nodes row by row: x grows with col, y with row.
/// Each cell is cut into two triangles, diagonals alternating (union jack) so that no direction is preferred.
/// size_x, size_y > 0 (m); cells_x, cells_y >= 1.
TriangleMesh make_grid(double size_x, double size_y, int cells_x, int cells_y);

/// Undirected edges (i < j), sorted, each once.
std::vector<std::array<int, 2>> edges_of(const TriangleMesh& mesh);

/// Interior edges with their two opposite nodes: {edge_a, edge_b, opposite_1, opposite_2}.
std::vector<std::array<int, 4>> hinges_of(const TriangleMesh& mesh);

/// Unit normals of the nodes at x (3 x n, m): the faces around each, weighted by area, on the outer side. +z at a node
/// whose faces cancel or vanish, for a drawing must not get NaN.
Nodes vertex_normals(const TriangleMesh& mesh, const Eigen::Ref<const Nodes>& x);

/// Volume (m^3) inside a closed mesh; < 0 where its faces are wound clockwise seen from outside.
double enclosed_volume(const TriangleMesh& mesh);

/// Whether every edge has two faces. Of a mesh that check_mesh() passes.
bool is_closed(const TriangleMesh& mesh);

/// Throws InputError naming the offending face or edge: index out of range, repeated node, zero area, non-finite
/// vertex, an edge shared by more than two faces, faces on one edge wound the same way, unused vertex.
void check_mesh(const TriangleMesh& mesh);

}  // namespace deformable_sim
