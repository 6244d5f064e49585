// Materials as networks of springs: which nodes are linked, how stiff, so that a traction test gives the material back.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "deformable_sim/core/topology/polyline.h"
#include "deformable_sim/core/topology/tet_mesh.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// One spring with a damper along it.
struct SpringLink {
  int a = 0, b = 0;          // body-local nodes
  double rest_length = 0.0;  // m, > 0
  double stiffness = 0.0;    // N/m, > 0
  double damping = 0.0;      // N s/m, >= 0
};

/// Lists are empty for what a body does not have; no link has zero stiffness.
struct SpringNetwork {
  std::vector<SpringLink> stretch, shear, bend;
};

struct SheetStiffness {
  double membrane = 0.0;          // E h, N/m
  double poissons_ratio = 0.25;   // grids only
  std::optional<double> stretch;  // N/m per structural spring (half on a free edge); replaces `membrane`
  std::optional<double> shear;    // N/m per shear spring, grids only; 0 = none
  std::optional<double> bend;     // N/m per bend spring; 0 = none
  double damping_time = 0.0;      // s, damping = damping_time * stiffness
};

/// A network as a list of links. A rest length of 0 means the distance of the nodes as they lie. All links are
/// `stretch`. Throws InputError naming the link: node out of range, both ends the same, a pair linked twice, stiffness
/// not > 0, damping or rest length negative, or nodes that coincide and no rest length.
SpringNetwork list_network(const Nodes& nodes, std::vector<SpringLink> links);

/// Grids: structural (rows, columns), shear (both cell diagonals), bend (over two cells). Other meshes: stretch along
/// every edge (Van Gelder weights, scaled to the modulus), bend across every interior edge, no separate shear springs.
SpringNetwork sheet_network(const TriangleMesh& mesh, const SheetStiffness& stiffness);

/// Which stiffness the springs on a free edge have: they belong to one cell, not two.
enum class SheetEdge { kHalved, kFull };

/// Stiffness of the springs of a Provot sheet, N/m each.
struct ProvotStiffness {
  double structural = 0.0;              // to the 4 neighbours (1, 0), (0, 1), ...; > 0
  double shear = 0.0;                   // to the 4 neighbours (1, 1), (1, -1), ...; 0 = none
  double flexion = 0.0;                 // to the 4 neighbours (2, 0), (0, 2), ...; 0 = none
  double damping_time = 0.0;            // s
  SheetEdge edge = SheetEdge::kHalved;  // kFull: as published; an n-cell strip is then (n + 1) / n too stiff
};

/// The sheet of [Provot 1995] on a grid: 12 neighbours of an inner node. Flexion springs become `bend`.
/// Throws InputError: not a grid, or a stiffness that is none.
SpringNetwork provot_network(const TriangleMesh& grid, const ProvotStiffness& stiffness);

/// Which neighbours a node of a cubic lattice is linked to: along the edges of the cells (6), also along the diagonals
/// of their faces (18), also along those of the cells (26).
enum class LatticeNeighbours { kEdges = 6, kFaces = 18, kBodies = 26 };

struct LatticeStiffness {
  LatticeNeighbours neighbours = LatticeNeighbours::kFaces;
  double youngs_modulus = 0.0;  // Pa
  /// N/m per spring {edge, face diagonal, body diagonal} inside the body; replaces `youngs_modulus`. Cubic cells only.
  std::optional<std::array<double, 3>> springs;
  double damping_time = 0.0;  // s
};

/// Corners of one box-shaped cell, x fastest, then y, then z: bit 0 of the index is x, bit 1 y, bit 2 z.
using LatticeCell = std::array<int, 8>;

/// The cells of a regular lattice that the tetrahedra of `mesh` fill, as make_box and make_lattice_around cut them.
/// cell: edge lengths, m. Throws InputError where the nodes are not those of such a lattice.
std::vector<LatticeCell> lattice_cells(const TetMesh& mesh, const Vec3& cell);

/// Springs of a soft body. Every cell brings its own share: an edge inside is shared by four cells, a face diagonal by
/// two, so springs on the surface have a quarter, a half, three quarters of k, and every cell, wherever it lies, has
/// the moduli of the infinite lattice. With `youngs_modulus` the lattice is isotropic with nu = 1/4 (cubes: k1 = k2 +
/// 8/3 k3; 26 neighbours: k3 = k2), which is all that central springs can do; 6 neighbours have nu = 0 and no shear
/// stiffness. Face diagonals are `shear`, body diagonals `bend`.
/// Throws InputError: nothing > 0, cells too elongated for an isotropic lattice, `springs` with cells that are no
/// cubes.
SpringNetwork lattice_network(const Nodes& rest, const std::vector<LatticeCell>& cells,
                              const LatticeStiffness& stiffness);

/// Lumped masses (kg per node): an eighth of each cell.
Eigen::VectorXd lattice_masses(const Nodes& rest, const std::vector<LatticeCell>& cells, double density);

struct LineStiffness {
  double axial = 0.0;             // E A, N
  std::optional<double> stretch;  // N/m per segment; replaces `axial`
  std::optional<double> bend;     // N/m per bend spring (over two segments); 0 = none
  double damping_time = 0.0;      // s
};
SpringNetwork line_network(const Polyline& line, const LineStiffness& stiffness);

/// Lumped masses (kg per node): a quarter of each cell (grids), a third of each triangle, half of each segment.
Eigen::VectorXd sheet_masses(const TriangleMesh& mesh, double areal_density);
Eigen::VectorXd line_masses(const Polyline& line, double linear_density);

}  // namespace deformable_sim
