// Constructors of the time schemes; scenes choose by name through make_integrator. Amplitudes are those of an undamped
// oscillator of frequency omega; the limits are for omega dt at a damping ratio zeta. See doc/theory/integrators.md.
#pragma once

#include <memory>

#include "deformable_sim/core/integrator/integrator.h"

namespace deformable_sim {

/// x += dt v, v += dt a(x, v). First order. An amplitude grows by sqrt(1 + (omega dt)^2) a step: unstable at any step
/// without damping; with zeta <= 1 the limit is 2 zeta (0.2 at zeta = 0.1), beyond 2 / (zeta + sqrt(zeta^2 - 1)).
/// The teaching baseline, good for nothing else.
std::unique_ptr<Integrator> make_explicit_euler();

/// v += dt a(x, v), x += dt v. First order. No damping: v^2 + omega^2 x^2 - dt omega^2 x v is conserved, so that the
/// energy wavers by (omega dt / 2) / (1 - omega dt / 2) and never drifts; linear and angular momentum are conserved.
/// Limit 2 (sqrt(1 + zeta^2) - zeta): 2 undamped, 1.81 at zeta = 0.1, 0.83 at 1.
std::unique_ptr<Integrator> make_symplectic_euler();

/// v += dt/2 a(x, v), x += dt v, v += dt/2 a(x, v). Second order; symplectic: no damping, no drift, momenta conserved.
/// Limit 2 undamped; the damping lags by half a step: 1.91 at zeta = 0.1, 1.85 at 0.2, 2 at 0.5 and 1, 2 / zeta beyond.
/// Not good at: forces that depend on velocity, which it integrates to first order only. Two force evaluations a step.
std::unique_ptr<Integrator> make_velocity_verlet();

/// Velocity Verlet in as many equal parts of the step as the body's own limit asks for, contacts searched once for all
/// of them. Order 2, 1 with forces of velocity; no numerical damping; any step. Sheets on grids run in SIMD kernels:
/// the cheapest way to small errors and to soft or small sheets. Not good at: stiff or finely meshed bodies, whose
/// parts become many: cost grows with the square root of stiffness and, per node, with the number of nodes along a
/// side.
std::unique_ptr<Integrator> make_substepped_verlet(const SolverSettings& settings);

/// The classical four-stage Runge-Kutta scheme. Fourth order on smooth motion. Damps by (omega dt)^6 / 144 a step:
/// 0.6 % at omega dt = 1, 25 % at 2. Limit 2 sqrt(2) undamped, 2.95 at zeta = 0.1, 2.79 at 1, 0.75 at 2.
/// Not good at: stiff bodies (four evaluations for 1.4 times the step), contacts (resolved after the step).
std::unique_ptr<Integrator> make_rk4();

/// v+ = v + dt a(x+, v+), x+ = x + dt v+ by Newton's method. First order, no step limit. Damps: an amplitude falls to
/// 1 / sqrt(1 + (omega dt)^2) each step (a damping ratio of omega dt / 2), the frequency to atan(omega dt) / dt; a free
/// rotation slows down by 1 / sqrt(1 + 2 n (omega dt)^2) in n steps. What is stiff vanishes at once.
/// Not good at: keeping motion alive (5 Hz at dt = 1/60 s: 5e-7 of the energy is left after a second).
std::unique_ptr<Integrator> make_implicit_euler(const SolverSettings& settings);

/// Implicit Euler with the forces linearised about the start of the step, the full Jacobian included: one linear solve
/// [Baraff 1998]. On linear forces it is implicit Euler: the same order, damping and (lack of a) limit.
/// Not good at: large steps of bodies whose stiffness changes in a step (slack cloth, large rotations): nothing is
/// iterated, errors and strains are larger; springs compressed beyond m / dt^2 make the matrix indefinite, then the
/// projected one is used. Contacts are solved as in implicit Euler, on the linearised forces.
std::unique_ptr<Integrator> make_linear_implicit_euler(const SolverSettings& settings);

/// M (v+ - v) / dt = f((x + x+) / 2, (v + v+) / 2), x+ = x + dt (v + v+) / 2. Second order, no step limit, no damping:
/// |R| = 1 at every omega dt, the phase is 2 atan(omega dt / 2); quadratic invariants (momenta, the energy of linear
/// bodies) are conserved. A step in which some node is within reach of a collider is one of implicit Euler.
/// Not good at: what is stiff and should come to rest: it rings on, turning round each step (R(infinity) = -1), and a
/// nonlinear body can gain energy.
std::unique_ptr<Integrator> make_implicit_midpoint(const SolverSettings& settings);

/// Second backward difference formula for variable steps. Second order, no step limit, one solve a step as in implicit
/// Euler. Damps the slow little and the stiff fully: 2.4e-5 a step at omega dt = 0.1, 6.7 % at 1, 70 % at 10;
/// R(infinity) = 0. Remembers one state (State::x_before, v_before, dt_before); its first step, and one longer than
/// twice the last, is a step of tr_bdf2. Nodes within reach of a collider follow implicit Euler, and begin anew after
/// it. Not good at: sudden events away from colliders (a jump of a target, a strain limit), after which it overshoots
/// for a step; steps whose length changes by more than a factor two all the time.
std::unique_ptr<Integrator> make_bdf2(const SolverSettings& settings);

/// TR-BDF2: the trapezoidal rule to t + gamma dt, BDF2 from there to t + dt, gamma = 2 - sqrt(2). Second order, no step
/// limit, remembers nothing. Damps less than BDF2, 3.7e-7 a step at omega dt = 0.1, 0.31 % at 1, 56 % at 10;
/// R(infinity) = 0. Two solves a step with one matrix. Nodes within reach of a collider follow implicit Euler, twice.
/// Not good at: cost; a step that is rough rather than smooth gains nothing over two of implicit Euler.
std::unique_ptr<Integrator> make_tr_bdf2(const SolverSettings& settings);

/// Tensions of springs as unknowns (XPBD), in the formula of BDF2: warp, weft and diagonal lines of sheets on grids,
/// and chains of springs elsewhere, are each solved directly, `newton_iterations` sweeps a step; quadratic bending
/// implicitly, drag per mass and soft grasps exactly, other forces on nodes at an extrapolated state. Second order, no
/// step limit; BDF2's damping. Cost and error hardly depend on the stiffness of springs.
/// Not good at: rest. What gravity does in a step is undone line by line, once a sweep, so that a hanging sheet is
/// stretched too far or too little by an amount that shrinks with the square of the step (doc/theory/integrators.md
/// has figures): StepReport::residual says so. Warm tensions would blow up. Refuses finite elements, rods, hinges.
std::unique_ptr<Integrator> make_line_dual(const SolverSettings& settings);

/// Extended position-based dynamics [Macklin 2016]: as line_dual with every spring for itself, in the formula of
/// implicit Euler. First order, no step limit. A competitor of the study, not a recommendation: the cheapest sweep to
/// write down. Not good at: meshes beyond some twenty nodes a side, across which a sweep carries nothing; rest, as
/// line_dual, and worse; keeping motion alive.
std::unique_ptr<Integrator> make_xpbd(const SolverSettings& settings);

/// Projective dynamics [Bouaziz 2014]: implicit Euler by x += A^-1 r, A one constant matrix that is factorised once for
/// a step and a set of held nodes, r the unbalanced force, from the positions at the start of the step,
/// `newton_iterations` times or to the tolerance. First order, no step limit; at rest exact. A competitor of the study.
/// Not good at: motion of what is stiff, which a few iterations freeze in mid-air without a sign but
/// StepReport::residual; steps of changing length, a factorisation each; large meshes, whose factors fill up.
std::unique_ptr<Integrator> make_projective_dynamics(const SolverSettings& settings);

}  // namespace deformable_sim
