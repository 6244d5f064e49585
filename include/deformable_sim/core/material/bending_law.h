// A sheet's resistance to bending: rigidity by direction, damping, rest angles.
#pragma once

#include <optional>
#include <vector>

#include "deformable_sim/core/topology/triangle_mesh.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// A fold pressed into an edge of the mesh.
struct Crease {
  int node_a = 0, node_b = 0;  // body-local
  double angle = 0.0;          // rad in (-pi, pi): > 0 folds the outer side inwards (a valley seen from outside)
};

/// Moments per width (N m) of curvatures (1/m).
///
///   warp, weft      bending a narrow strip cut along each direction: what a cantilever test measures, E h^3 / 12
///   poissons_ratio  curvature across over curvature along, opposite in sign, of a free strip cut along the warp
///   twist           twisting moment M_xy per 2 kappa_xy, G h^3 / 12; unless given, (1 - sqrt(nu_1 nu_2)) / 2 times
///                   the geometric mean of the plate rigidities D11, D22: the isotropic plate's when warp = weft
///
/// warp, weft, twist > 0, nu^2 weft / warp < 1.
struct BendingMaterial {
  enum class Rest { kFlat, kAsMeshed };
  double warp = 0.0, weft = 0.0;  // N m
  double poissons_ratio = 0.0;
  std::optional<double> twist;  // N m
  double damping = 0.0;         // s: viscous moment = damping x rigidity x rate of curvature
  Rest rest = Rest::kFlat;
  std::vector<Crease> creases;          // replace the rest angles of their edges
  Vec3 warp_direction = Vec3::UnitX();  // in the rest mesh; projected onto each triangle
};

/// From the rigidity B = E h^3 / 12 of a narrow strip and nu; the plate's is D = B / (1 - nu^2).
BendingMaterial isotropic_bending(double rigidity, double poissons_ratio);

/// Throws InputError naming the value and what is allowed.
void check_material(const BendingMaterial& material);

/// Moments (M_xx, M_yy, M_xy) of curvatures (k_xx, k_yy, 2 k_xy), x along the warp; N m, symmetric positive definite.
Mat3 plate_stiffness(const BendingMaterial& material);

/// One weight w (N/m, also < 0) of a quadratic energy, E = w/2 |x_b - x_a|^2; body-local nodes, a < b.
struct QuadraticWeight {
  int a, b;
  double weight;
};

/// The plate of `material` on a regular grid by differences, see grid_bending.cpp: warp along the rows. Second order in
/// the cells; rest is flat. Throws InputError: not a grid, or no material.
std::vector<QuadraticWeight> grid_bending_weights(const TriangleMesh& grid, const BendingMaterial& material);

}  // namespace deformable_sim
