// Soft volumes as terms of the equations of motion: forces, masses, stresses.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/SparseCore>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/core/topology/tet_mesh.h"

namespace deformable_sim {

/// Elastic and viscous forces of a volume, linear or quadratic as the mesh is. `first_node` shifts its nodes.
/// strain_rate_damping: tau >= 0 (s), see SolidTetrahedron. Named "tetrahedra: " or "quadratic tetrahedra: " and the
/// law. Throws InputError (also for what check_mesh refuses).
std::unique_ptr<Energy> make_solid(const TetMesh& mesh, const SolidMaterial& material, double strain_rate_damping,
                                   int first_node);

/// kg per node, all > 0: a quarter of each linear tetrahedron; of a quadratic one 1/36 to a corner, 4/27 to a middle
/// node (the diagonal of the consistent matrix, scaled to the mass) [Hinton 1976]. density > 0, kg/m^3.
Eigen::VectorXd solid_masses(const TetMesh& mesh, double density);

/// integral of density N_a N_b, n x n, kg: the same for x, y and z.
Eigen::SparseMatrix<double> solid_mass_matrix(const TetMesh& mesh, double density);

/// F of each element at its centroid, x (3 x n, m) the positions of the mesh's nodes.
std::vector<Mat3> deformation_gradients(const TetMesh& mesh, const Nodes& x);

/// Cauchy stress at the nodes (Pa): mean of the elements around, by volume; quadratic elements are extrapolated from
/// their points of quadrature to the corners, and middle nodes take the mean of the two corners.
std::vector<Mat3> solid_cauchy_stress(const TetMesh& mesh, const SolidMaterial& material, const Nodes& x);

/// von Mises' equivalent of it, Pa, at most kLargestStress.
Eigen::VectorXf solid_stress(const TetMesh& mesh, const SolidMaterial& material, const Nodes& x);

/// Expected ratio of a bending deflection of this mesh to the right one, for bending across its thinnest direction,
/// with n = thickness / mean height of the elements across it:
///
///   mirrored cubes (make_box, make_lattice_around)   1 / (1 + (2.6 + 0.84 (2 nu)^8) / n^2)
///   other linear elements                            1 / (1 + 6.2 mu/E / n^2 + 1 / |(a, b)|)
///       1 / a = 2.1 (lambda/E)^0.87 / n^1.66,  1 / b = 65 / n^0.2
///   quadratic elements                               1 / (1 + 0.028 (2 nu)^2 + (0.063 (2 nu)^2 + 0.088 (2 nu)^10) /
///   n^2)
///
/// Linear elements cannot bend, their strain is constant (locking). Quadratic ones can, within 1 % at any nu; theirs is
/// the factor of a clamp that does not let the section contract, over a beam ten times as long as thick: the longer
/// the beam, the nearer to 1. Fitted to cantilevers of that length with 1 to 6 cubes through the thickness and
/// nu <= 0.499: within 7 %, 5 % (cubes all cut alike) and 1 % (3 % for cubes cut alike); an irregular mesh may be
/// anywhere about it. poissons_ratio < 0.5; below 0 it counts as 0. See doc/theory/finite_elements.md.
double expected_bending_factor(const TetMesh& mesh, double poissons_ratio);

}  // namespace deformable_sim
