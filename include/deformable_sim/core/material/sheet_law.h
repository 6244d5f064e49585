// Stress-strain laws of thin sheets in their own plane, per length: energy by area, stress in N/m.
#pragma once

#include <Eigen/Core>

#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// A sheet's resistance to stretch and shear. Stiffness is force per width (N/m): Young's modulus times thickness.
///
///   warp, weft      traction along each yarn direction, the sides free
///   poissons_ratio  contraction along the weft per extension along the warp, pulled along the warp
///   shear           shear force per width and shear angle
///
/// All stiffness > 0, |nu| < 1, nu^2 weft / warp < 1. St Venant-Kirchhoff and linear Hooke take any of these; the other
/// laws are isotropic: warp = weft, shear = warp / (2 (1 + nu)), and nu < 1/2.
struct SheetMaterial {
  SolidLaw law = SolidLaw::kStVenantKirchhoff;
  double warp = 0.0, weft = 0.0;  // N/m
  double poissons_ratio = 0.0;
  double shear = 0.0;                   // N/m
  double share = 0.5;                   // Mooney-Rivlin only, see SolidMaterial
  double thickness = 0.0;               // m; only divides stress when it is reported in Pa; 0: reported in N/m
  double damping = 0.0;                 // s: viscous stress = damping x stiffness x strain rate
  Vec3 warp_direction = Vec3::UnitX();  // in the rest mesh; projected onto each triangle
};

/// From E h (N/m) and nu.
SheetMaterial isotropic_sheet(SolidLaw law, double membrane, double poissons_ratio);

/// Throws InputError naming the value and what is allowed.
void check_material(const SheetMaterial& material);

/// Throws InputError unless finite and not zero.
void check_direction(const Vec3& warp_direction);

/// Plane-stress stiffness of small strains (e_warp, e_weft, 2 e_shear), N/m, symmetric positive definite:
///
///   C11 = warp / (1 - nu^2 weft / warp),  C22 = C11 weft / warp,  C12 = nu C22,  C33 = shear.
Mat3 plane_stiffness(const SheetMaterial& material);

/// Energy per rest area (J/m^2) of an isotropic sheet as a function of its two principal stretches s, its gradient and,
/// when asked for, its Hessian. The thickness stretch t is eliminated, so that the stress across the sheet vanishes:
///
///   W(s) = psi(s1, s2, t),  dpsi/dt = 0,   W_i = psi_i,   W_ij = psi_ij - psi_it psi_jt / psi_tt.
///
/// Corotational and St Venant-Kirchhoff: in closed form, lambda replaced by 2 mu lambda / (lambda + 2 mu).
double plane_stress_energy(const SolidMaterial& material, const Eigen::Vector2d& s, Eigen::Vector2d* gradient,
                           Eigen::Matrix2d* hessian);

/// Where warp and weft run in a face: the warp direction, or zero when the stiffness (of stretch or of bending) is the
/// same in all directions and the face may choose.
Vec3 direction_that_matters(const Mat3& stiffness, const Vec3& warp_direction);

/// The solid whose sheet this is, per length: mu and lambda in N/m. Isotropic materials only.
SolidMaterial solid_of(const SheetMaterial& material);

}  // namespace deformable_sim
