// Isotropic stress-strain laws of solids, by principal stretches.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

enum class SolidLaw { kHooke, kCorotational, kStVenantKirchhoff, kNeoHookean, kStableNeoHookean, kMooneyRivlin };

/// Names used in scenes: hooke, corotational, st_venant_kirchhoff, neo_hookean, stable_neo_hookean, mooney_rivlin.
std::vector<std::string> solid_law_names();
/// Throws InputError listing the names.
SolidLaw solid_law(const std::string& name);

struct SolidMaterial {
  SolidLaw law = SolidLaw::kStableNeoHookean;
  double mu = 0.0, lambda = 0.0;  // Pa, Lame's; mu > 0, lambda > -2/3 mu
  double share = 0.5;             // Mooney-Rivlin: C10 = share mu / 2, C01 = (1 - share) mu / 2
};

/// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)). Throws InputError unless E > 0 and -1 < nu < 1/2,
/// neo-Hookean nu >= 0: with lambda < 0 its energy goes to minus infinity with J to 0.
SolidMaterial solid_material(SolidLaw law, double youngs_modulus, double poissons_ratio);

/// Energy per rest volume (Pa) as a function of the principal stretches s (singular values of F, the last one negative
/// under inversion), its gradient, and its Hessian when asked for (null: not). With e_i = s_i - 1, E_i = (s_i^2 - 1) /
/// 2, J = s_1 s_2 s_3, I1 = sum s_i^2, I2 = sum s_i^2 s_j^2:
///
///   corotational          mu sum e_i^2 + lambda/2 (sum e_i)^2
///   St Venant-Kirchhoff   mu sum E_i^2 + lambda/2 (sum E_i)^2
///   neo-Hookean           mu/2 (I1 - 3) - mu ln J + lambda/2 ln^2 J                                     [Bonet 2008]
///   stable neo-Hookean    m/2 (I1 - 3) + l/2 (J - a)^2 - m/2 ln (I1 + 1) - its value at rest,
///                         m = 4/3 mu, l = lambda + 5/6 mu, a = 1 + 3 m / (4 l)                          [Smith 2018]
///   Mooney-Rivlin         C10 (J^(-2/3) I1 - 3) + C01 (J^(-4/3) I2 - 3) + K/2 (J - 1)^2, K = lambda + 2/3 mu
///
/// Every law but Hooke's linear one, which is no function of the stretches. Neo-Hookean and Mooney-Rivlin are undefined
/// for J <= 0: the energy is infinite there, its derivatives are not numbers.
double energy_density(const SolidMaterial& material, const Vec3& s, Vec3* gradient, Mat3* hessian);

/// What the Hessian with respect to F has beside the one with respect to the stretches: for each pair i, j of principal
/// directions, at the index of the third one, with g the gradient above,
///
///   twist = (g_i + g_j) / (s_i + s_j)      flip = (g_i - g_j) / (s_i - s_j)
///
/// (Pa), written so that equal stretches need no limit [Smith 2019]. The corotational twist has a pole where s_i = -s_j
/// (the rotation jumps there); its denominator is kept above 1e-6.
void pair_moduli(const SolidMaterial& material, const Vec3& s, Vec3* twist, Vec3* flip);

}  // namespace deformable_sim
