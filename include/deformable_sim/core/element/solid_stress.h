// Stress and tangent moduli of a solid from its deformation gradient.
#pragma once

#include "deformable_sim/core/element/jacobian.h"
#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// F = u diag(s) v^T with rotations u and v. When det F <= 0 the last stretch is the smallest in size, and not
/// positive; all others are positive.
struct SignedSvd {
  Mat3 u, v;
  Vec3 s;
};
SignedSvd signed_svd(const Mat3& f);

/// The rotation next to F: R of F = R S, S symmetric. Under inversion S has one negative eigenvalue, its smallest in
/// size, so that the element turns back through its thinnest direction.
Mat3 polar_rotation(const Mat3& f);

/// Energy per rest volume (Pa) at the deformation gradient F (dx/dX). Hooke: mu |e|^2 + lambda/2 tr^2 e with
/// e = (F + F^T) / 2 - I; the others are energy_density(material, s, ...) of the stretches of F.
double energy_density(const SolidMaterial& material, const Mat3& f);

/// First Piola-Kirchhoff stress P = d(energy density)/dF (Pa): force per rest area. Direct formulas; only the
/// corotational law needs the rotation. Not a number where the law is undefined (neo-Hookean, Mooney-Rivlin, J <= 0).
Mat3 first_piola(const SolidMaterial& material, const Mat3& f);

/// Cauchy stress P F^T / J (Pa): force per deformed area. Hooke: P itself, the linear law knows only one area.
Mat3 cauchy_stress(const SolidMaterial& material, const Mat3& f);

/// sqrt(3/2 s:s), s the deviator of the Cauchy stress (Pa).
double von_mises(const Mat3& cauchy);

Mat3 cauchy_green_right(const Mat3& f);  // C = F^T F
Mat3 cauchy_green_left(const Mat3& f);   // B = F F^T
Mat3 green_lagrange(const Mat3& f);      // E = (C - I) / 2

/// dP/dF by its eigen-system [Smith 2019]. With principal directions u_i, v_i of F = u diag(s) v^T,
///
///   dP[u_j v_j^T]             = sum_i scaling(i, j) u_i v_i^T
///   dP[u_i v_j^T - u_j v_i^T] = twist_k (u_i v_j^T - u_j v_i^T)      k the third index beside i, j
///   dP[u_i v_j^T + u_j v_i^T] = flip_k (u_i v_j^T + u_j v_i^T)
struct StressDerivative {
  Mat3 u, v;
  Mat3 scaling;
  Vec3 twist, flip;
};
/// Projected: negative eigenvalues are put to zero, which makes it the nearest positive semi-definite one [Teran 2005].
StressDerivative stress_derivative(const SolidMaterial& material, const Mat3& f, Jacobian kind);

}  // namespace deformable_sim
