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

/// mu = E / (2 (1 + nu)), lambda = E nu / ((1 + nu) (1 - 2 nu)). Throws InputError unless E > 0 and -1 < nu < 1/2.
SolidMaterial solid_material(SolidLaw law, double youngs_modulus, double poissons_ratio);

/// Energy per rest volume (Pa) as a function of the principal stretches s (singular values of F, the last one negative
/// under inversion), its gradient, and its Hessian when asked for. Every law but Hooke's linear one, which is no
/// function of the stretches. Infinite where the law is undefined (neo-Hookean, J <= 0).
double energy_density(const SolidMaterial& material, const Vec3& s, Vec3* gradient, Mat3* hessian);

}  // namespace deformable_sim
