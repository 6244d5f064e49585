// Constructors of the time schemes; scenes choose by name through make_integrator.
#pragma once

#include <memory>

#include "deformable_sim/core/integrator/integrator.h"

namespace deformable_sim {

/// x += dt v, v += dt a(x, v). First order; needs damping 2 zeta / omega >= dt to stay bounded. The teaching baseline.
std::unique_ptr<Integrator> make_explicit_euler();

/// v += dt a(x, v), x += dt v. First order, keeps a nearby energy and both momenta; stable for omega dt < 2.
std::unique_ptr<Integrator> make_symplectic_euler();

/// The classical four-stage Runge-Kutta scheme. Fourth order on smooth motion; contacts are resolved after the step.
std::unique_ptr<Integrator> make_rk4();

/// v+ = v + dt a(x+, v+), x+ = x + dt v+ by Newton's method. First order, no step limit. Dissipates: an oscillation of
/// frequency omega loses the factor 1 / sqrt(1 + (omega dt)^2) of its amplitude each step, and rotation slows down.
std::unique_ptr<Integrator> make_implicit_euler(const SolverSettings& settings);

}  // namespace deformable_sim
