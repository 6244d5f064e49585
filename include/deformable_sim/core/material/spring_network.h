// Materials as networks of springs: which nodes are linked, how stiff, so that a traction test gives the material back.
#pragma once

#include <optional>
#include <vector>

#include "deformable_sim/core/topology/polyline.h"
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

/// Grids: structural (rows, columns), shear (both cell diagonals), bend (over two cells). Other meshes: stretch along
/// every edge (Van Gelder weights, scaled to the modulus), bend across every interior edge, no separate shear springs.
SpringNetwork sheet_network(const TriangleMesh& mesh, const SheetStiffness& stiffness);

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
