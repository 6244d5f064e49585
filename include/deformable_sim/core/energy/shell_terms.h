// Cloth as a continuum: terms of stretch and of bending over a triangle mesh, and what they say about a state.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/material/bending_law.h"
#include "deformable_sim/core/material/sheet_law.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {

/// Constant-strain triangles, damped by their strain rate; `first_node` shifts body-local nodes. See
/// doc/theory/shells.md. Throws InputError when the material is not one, or its stiffness differs by direction and the
/// warp is normal to a face.
std::unique_ptr<Energy> make_membrane(const TriangleMesh& mesh, const SheetMaterial& material, int first_node);

/// Plate bending by the angles between neighbouring triangles, with the material's stiffness at any mesh and any
/// orientation. Throws InputError as make_membrane, and when a crease is no interior edge.
/// Not good at: sharp folds through pi, beyond which an angle counts from the other side; meshes without a hinge.
std::unique_ptr<Energy> make_bending(const TriangleMesh& mesh, const BendingMaterial& material, int first_node);

/// The same stiffness with a constant Hessian, for sheets that hardly stretch: 2 sin(angle / 2) in place of the angle.
/// Rest is flat: throws InputError when the material asks for other rest angles.
/// Not good at: stretching sheets, whose in-plane waves it resists a little; tight folds, where it is softer.
std::unique_ptr<Energy> make_quadratic_bending(const TriangleMesh& mesh, const BendingMaterial& material,
                                               int first_node);

/// The weights of that term, without damping; body-local nodes.
std::vector<QuadraticWeight> quadratic_bending_weights(const TriangleMesh& mesh, const BendingMaterial& material);

/// A quadratic energy as a term: f = sum w (x_b - x_a + damping (v_b - v_a)) on a. Damping (s) as a constant matrix:
/// exactly 0 in translation, but it resists the turning of a curved sheet (moment: damping x rigidity x curvature x
/// rate of turning).
std::unique_ptr<Energy> make_quadratic_links(const std::string& name, const std::vector<QuadraticWeight>& weights,
                                             double damping, int first_node);

/// Weights as of a quadratic energy, f = sum w (y_b - y_a) on a; nodes of the weights count from first_node.
ConstantLinks make_constant_links(const std::vector<QuadraticWeight>& weights, double damping, int first_node);

/// Principal stretches - 1 at the nodes (2 x n, larger first): singular values of F, averaged over the faces by area.
Eigen::Matrix2Xf principal_strains(const TriangleMesh& mesh, const Nodes& x_body);

/// Principal Cauchy stresses at the nodes (2 x n, larger first), averaged over the faces by area: N/m, or Pa when the
/// material has a thickness (then of the unstretched thickness).
Eigen::Matrix2Xf principal_stresses(const TriangleMesh& mesh, const SheetMaterial& material, const Nodes& x_body);

/// Von Mises stress at the nodes from those: sqrt(a^2 - a b + b^2), at most kLargestStress.
Eigen::VectorXf sheet_stress(const TriangleMesh& mesh, const SheetMaterial& material, const Nodes& x_body);

}  // namespace deformable_sim
