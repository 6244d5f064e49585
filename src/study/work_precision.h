// Error against run time: what is run, what it cost and how far it is from the converged solution.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim::work_precision {

/// States are compared at T/4, T/2, 3T/4 and T; every step divides a quarter.
constexpr int kQuarters = 4;
/// Newton's method until its residual is down to rounding.
constexpr int kConverged = 1000;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// One way to run a scene.
struct Configuration {
  std::string integrator;
  std::string linear_solver;         // empty: an explicit scheme
  int newton_iterations = 0;         // at most, per stage; kConverged; sweeps; 0 = explicit
  double linear_tolerance = 0.0;     // cg, multigrid
  int linear_iterations = 0;         // cg, multigrid: at most; 0 = a factorisation
  std::string precision = "double";  // of sheets on grids, substepped_verlet
  double fraction = 0.95;            // of the longest stable part, substepped_verlet
  int steps = 1;                     // in a quarter of the run

  bool is_explicit() const { return linear_solver.empty(); }
  bool is_converged() const { return newton_iterations == kConverged; }
  bool is_iterative() const { return linear_iterations > 0; }
  /// "converged", "2", "-".
  std::string newton_text() const;
  /// "cg 0.1 x 200", "direct", "-".
  std::string linear_text() const;
  /// All but the step: "bdf2, cg 0.1 x 200, Newton 2".
  std::string family() const;
  /// The whole, as a key.
  std::string key() const;
};

/// What is compared of one instant.
struct Sample {
  Nodes x;                             // 3 x nodes, m; angle columns of rods behind the points
  double kinetic = 0.0, stored = 0.0;  // J; stored: elastic and of gravity
  Eigen::Matrix<double, 6, Eigen::Dynamic>
      pull;  // force (N) and torque (N m) of each grasp, mean over the quarter before
};

using Trajectory = std::vector<Sample>;  // kQuarters of them

/// CPU time of this thread and counts, per simulated second without the first step.
struct Cost {
  double cpu = kNone;                // s
  double first_step = kNone;         // s, with what is set up once
  double force_evaluations = kNone;  // all terms once = 1; what a stability limit is measured with is not counted
  double newton_iterations = kNone;
  double linear_iterations = kNone;
  double unconverged = 0.0;  // share of the steps that missed the Newton tolerance
};

/// Distance from a reference; NaN where there is nothing to compare.
struct Errors {
  double position = kNone;      // RMS over the points, relative to their body's size; largest of the four instants
  double position_end = kNone;  // the same at the end
  double energy = kNone;        // of the energy that moves in the reference; largest of the four
  double measure = kNone;       // length of ropes, area of cloth, volume of solids, relative; largest of the four
  double strain = kNone;        // of any edge; largest of the four
  double grasp = kNone;         // force and torque at grasps, of the largest force; largest of the four
};

enum class Status { kDone, kDiverged, kStopped };
std::string status_text(Status status);
/// Throws InputError.
Status status_of(const std::string& text);

/// One run of the sweep.
struct Row {
  Configuration configuration;
  double dt = 0.0;  // s
  Status status = Status::kDone;
  std::string note;  // why it diverged or was stopped
  Cost cost;
  double cpu_seconds = 0.0;     // of the run
  Errors errors;                // against the reference
  double time_error = kNone;    // of the position: the same scheme and step with converged Newton against the reference
  double solver_error = kNone;  // of the position: against the same scheme and step with converged Newton

  /// Of Newton's iterations enough that the result can be trusted: at most one step in a hundred missed the tolerance.
  bool settled() const { return cost.unconverged <= 0.01; }
};

/// The solution that runs are compared with.
struct Reference {
  Trajectory trajectory;
  std::string method;                           // "rk4, step halved 3 times to 1.2e-05 s"
  double reached = kNone;                       // relative RMS of the positions between the last two halvings
  std::string check_method;                     // another scheme
  double check_reached = kNone;                 // how far that one has converged itself
  double check_difference = kNone;              // between the two
  std::vector<std::array<double, 2>> halvings;  // dt (s), difference to the one before

  /// Errors below this mean nothing: three times what has been reached, or by how much the two disagree where neither's
  /// own convergence explains it.
  double resolution() const;
};

/// A part of the error that belongs to the scene, not to a solver.
struct Part {
  double position = kNone;   // relative RMS
  double uncertain = kNone;  // error of the run it was measured with
  std::string how;           // with what, or why not
};

/// The cheapest run that meets an error.
struct Pick {
  double wanted = 0.0;
  int row = -1;     // none
  std::string why;  // none: why not
};

/// Facts of a scene that a choice of solver may rest on.
struct Features {
  std::string kind;    // cloth, rope, soft, mixed
  std::string bodies;  // SceneFeatures; empty: no choice of solver is about it
  int nodes = 0;
  double stiffness_ratio = kNone;  // E h / (rho h g L), E A / (rho A g L), E / (rho g L) of the first body
  double explicit_steps = kNone;   // of velocity Verlet in 1/60 s, at its limit
  bool contact = false, strain_limits = false;
};

struct Result {
  std::string name, title, digest, version;
  double seconds = 1.0;  // simulated
  Features features;
  Reference reference;
  std::vector<Row> rows;
  std::vector<int> front;  // rows, by cost; each has a smaller error than all cheaper ones
  std::vector<Pick> picks;
  Part mesh, model;
  std::vector<std::string> left_out;  // families that were not run to the end, and why
};

}  // namespace deformable_sim::work_precision
