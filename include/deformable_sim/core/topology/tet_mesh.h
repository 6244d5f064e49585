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

}  // namespace deformable_sim
