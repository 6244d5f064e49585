// The interface of all time schemes, and what they are given.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/contact/constraint.h"
#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/grasp/kinematics.h"
#include "deformable_sim/core/grid/grid_sheet.h"
#include "deformable_sim/core/state.h"

namespace deformable_sim {

class Workers;

/// The equations of motion of one step: M dv/dt = sum of energies' forces, subject to kinematics and contacts.
struct Dynamics {
  const Eigen::VectorXd* mass = nullptr;  // n, kg, all > 0
  /// n x n, kg, symmetric: a consistent mass matrix in place of the lumped masses, which then only weigh residuals and
  /// share impulses. Its pattern is part of `pattern`. Null: lumped.
  const Eigen::SparseMatrix<double>* mass_matrix = nullptr;
  std::vector<const Energy*> energies;  // includes gravity and soft grasps
  Kinematics kinematics;
  ContactConstraints contacts;
  const BlockMatrix* pattern = nullptr;  // null for schemes that need no Jacobian
  /// Sheets on grids: what some schemes evaluate in place of the terms these stand for. Null: none.
  const std::vector<GridSheet>* grids = nullptr;
  const Workers* workers = nullptr;  // null: one thread
  bool bodies_meet = false;          // contacts may join nodes of different bodies
};

/// What a scheme asks to exist.
struct Needs {
  bool jacobian = false;
  bool lumped_mass = false;  // cannot do with Dynamics::mass_matrix
  bool links_apart = false;  // the pattern may lack springs and terms of constant links (stays_apart())
};

struct StepReport {
  bool converged = true;  // explicit schemes: state stayed finite
  int newton_iterations = 0;
  int linear_iterations = 0;
  int force_evaluations = 0;      // all terms once = 1
  double residual = 0.0;          // RMS unbalanced acceleration at the end of the step, m/s^2
  double seconds_assembly = 0.0;  // thread CPU time, s
  double seconds_solve = 0.0;
};

/// A time scheme. Holds only its settings and reusable work space; the state is the caller's.
class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual std::string name() const = 0;
  virtual Needs needs() const = 0;
  /// Observed order of accuracy on a smooth problem. Contacts and the straight paths of prescribed nodes are met to the
  /// first and second order at most.
  virtual int order() const = 0;
  /// The same where forces depend on velocities.
  virtual int order_with_velocity_forces() const { return order(); }
  /// Largest stable omega * dt of an oscillator of frequency omega and damping ratio zeta >= 0; 0 = unstable at any
  /// step, infinity = no limit.
  virtual double stability_limit(double zeta) const = 0;
  double stability_limit() const { return stability_limit(0.0); }
  /// Advances `s` by dt (s, > 0). Writes reactions and contact forces into `d`.
  virtual StepReport advance(double dt, Dynamics* d, State* s) = 0;
  /// Forgets anything cached about matrices (kinematic set or pattern changed by the caller in another world).
  virtual void reset() {}
};

/// Settings of implicit schemes; explicit ones ignore them.
struct SolverSettings {
  enum class Linear { kDirect, kConjugateGradient, kBanded, kMultigrid };
  Linear linear = Linear::kConjugateGradient;
  int newton_iterations = 4;      // at most, per step
  double tolerance = 0.02;        // RMS unbalanced acceleration at which Newton stops, m/s^2
  double linear_tolerance = 0.1;  // relative residual of one linear solve
  int linear_iterations = 200;    // at most, per linear solve
  /// Of sheets on grids and of springs on any mesh, where a scheme has kernels for them: single takes half to two
  /// thirds of the time and has an error of about 1e-4 of its own.
  enum class Precision { kDouble, kSingle };
  Precision precision = Precision::kDouble;
  /// Length of the parts of substepped_verlet over the longest stable one, 0 < f <= 0.95. Its error shrinks with f^2.
  double fraction_of_limit = 0.95;
  Jacobian jacobian = Jacobian::kProjected;  // what Newton's matrix is made of; lagged: see ImplicitStage
};

/// By name: explicit_euler, symplectic_euler, velocity_verlet, rk4, implicit_euler, linear_implicit_euler,
/// implicit_midpoint, bdf2, tr_bdf2, substepped_verlet. Throws InputError listing the names.
std::unique_ptr<Integrator> make_integrator(const std::string& name, const SolverSettings& settings);
std::vector<std::string> integrator_names();

/// Highest natural frequency (rad/s) of M^-1 K at state `s`, K = -df/dx by central differences of the forces, so that
/// no matrix has to exist; Lanczos' method. Kinematic nodes are held. Relative accuracy 0.1 % or better; rough: 1 %, by
/// one-sided differences and fewer of them.
enum class Effort { kFine, kRough };
double highest_frequency(const Dynamics& d, const State& s, Effort effort = Effort::kFine);

/// Highest rate (1/s) at which forces of velocity damp a motion of M v' = f(v) at state `s`, by power iteration.
/// Relative accuracy 5 %; rough: 1 %, by Lanczos' method where masses are lumped.
double highest_damping_rate(const Dynamics& d, const State& s, Effort effort = Effort::kFine);

/// Largest stable step (s) of an explicit scheme for a body of highest frequency omega (rad/s) and highest damping rate
/// (1/s), which need not belong to the same motion: the smaller of the limit of an oscillator that has both and of a
/// motion that is only damped. Schemes without any limit: infinity.
double stable_step(const Integrator& integrator, double omega, double damping_rate);

}  // namespace deformable_sim
