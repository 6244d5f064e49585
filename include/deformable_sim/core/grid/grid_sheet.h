// What fast kernels need to know of a sheet on a regular grid: its springs and its bending as a few rows of numbers.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "deformable_sim/core/material/bending_law.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

class Energy;

/// The springs of one direction. Between nodes that are `step` apart along it: stiffness along[k] * across[l] (N/m) for
/// the k-th spring of the l-th line.
struct GridSprings {
  double length = 0.0;                // m, at rest
  std::vector<double> along, across;  // empty: no such springs
  bool empty() const { return along.empty(); }
};

/// Where the nodes lie, in rows and columns, with which quadratic bending couples a node: a disc of radius 2.
constexpr int kStencilSize = 13;
constexpr std::array<std::array<int, 2>, kStencilSize> kStencil{
    {{-2, 0}, {-1, -1}, {-1, 0}, {-1, 1}, {0, -2}, {0, -1}, {0, 0}, {0, 1}, {0, 2}, {1, -1}, {1, 0}, {1, 1}, {2, 0}}};

/// A matrix over the stencil, the same for x, y and z. Rows of the grid with equal coefficients share them.
struct GridStencil {
  using Row = std::array<std::vector<double>, kStencilSize>;  // N/m, by column
  std::vector<Row> kind;
  std::vector<int> kind_of_row;  // empty: no bending
  bool empty() const { return kind_of_row.empty(); }
};

/// Springs along warp (columns grow), weft (rows grow) and both diagonals, over one cell and along warp and weft over
/// two; quadratic bending. The same forces as the terms it stands for, which stay the ones that say what they are.
///
/// Not good at: anything but a full rectangle with uniform cells; such a sheet has none.
struct GridSheet {
  int first_node = 0;
  int rows = 0, cols = 0;  // nodes; node = first_node + row * cols + col
  GridSprings warp, weft, warp_bend, weft_bend;
  double shear = 0.0;            // N/m, every diagonal; 0 = none
  double shear_length = 0.0;     // m
  double damping_time = 0.0;     // s, of all springs: c = damping_time * k
  GridStencil bending;           // K of f = -K (x + bending_damping v), N/m
  double bending_damping = 0.0;  // s
  /// The terms of the model that it stands for. They belong to the model.
  std::vector<const Energy*> replaces;

  int node_count() const { return rows * cols; }
};

/// None where the network is not that of a uniform grid.
std::optional<GridSheet> make_grid_sheet(const TriangleMesh& mesh, const SpringNetwork& network,
                                         const std::vector<QuadraticWeight>& bending, double bending_damping,
                                         int first_node);

}  // namespace deformable_sim
