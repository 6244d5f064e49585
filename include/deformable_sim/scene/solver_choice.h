// Which scheme, solver and step a scene gets that names none: the cheapest measured one that is accurate enough.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// SceneFeatures::bodies of sheets that fast kernels know.
constexpr char kSheetOnGrid[] = "sheet on a grid";

/// What a choice rests on. The same function of a scene for those that were measured and those that ask.
struct SceneFeatures {
  std::string bodies;           // kSheetOnGrid, "sheet", "rope", "rod", "solid", or "mixed"
  int nodes = 0;                // points of all bodies
  double explicit_steps = 0.0;  // of velocity Verlet in 1/60 s, at its stability limit: stiffness, mesh and mass in one
  bool contact = false;         // there is something to touch
  bool strain_limits = false;
};

/// `model`: of the scene. Costs some hundred evaluations of all forces.
SceneFeatures features_of(const SceneSpec& spec, const Model& model);

/// One way to run a scene.
struct SolverConfiguration {
  std::string integrator = "implicit_euler";
  std::string linear_solver;  // empty: an explicit scheme
  int newton_iterations = 0;
  double linear_tolerance = 0.0;  // cg, multigrid
  int linear_iterations = 0;      // cg, multigrid; 0: a factorisation
  std::string precision = "double";
  double fraction_of_limit = 0.95;
  double dt = 0.01;  // s

  std::string text() const;
};

/// `settings`, but for what the configuration says. ropes: a banded solver gets the lagged Jacobian that ropes get.
SolverSettings settings_of(const SolverConfiguration& configuration, SolverSettings settings, bool ropes);

/// What was measured: errors and costs of configurations over scenes (config/solvers.yaml, written by the study).
struct SolverTable {
  struct Run {
    size_t configuration;
    double error;  // RMS of the positions over 1 s, relative to the body's size
    double cpu;    // s per simulated s
  };
  struct Cheapest {
    double error, cpu;
  };
  struct Scene {
    std::string name;
    SceneFeatures features;
    std::vector<Run> runs;           // those worth taking
    std::vector<size_t> failed;      // configurations that diverged, or were off by too much
    std::vector<Cheapest> cheapest;  // for some errors, of all that was measured, also of what no choice offers
  };
  std::vector<SolverConfiguration> configurations;
  std::vector<Scene> scenes;
};

/// Throws InputError naming file and line.
SolverTable read_solver_table(const std::string& file);
/// package_dir()/config/solvers.yaml.
std::string solver_table_file();

struct SolverWish {
  double error = 0.01;
  double budget = 0.8;       // CPU s per simulated s; infinity: none
  std::optional<double> dt;  // s, of a step; none: as the configuration was measured
};

struct SolverChoice {
  SolverConfiguration configuration;
  int parts = 1;                                                                                            // of a step
  double error = std::numeric_limits<double>::quiet_NaN(), cpu = std::numeric_limits<double>::quiet_NaN();  // expected
  bool guessed = false;  // from scenes unlike this one: 64 times as many nodes or explicit steps, or as few
  std::string why;

  /// False: nothing like the scene was, and the configuration is what a scene's manual defaults are.
  bool measured() const { return error == error; }
};

/// The cheapest configuration whose expected error is at most the wanted one; of those within a fifth of its cost, the
/// most accurate. Errors and costs are those of the most
/// similar scenes, interpolated in the logarithms of nodes and explicit steps, errors made half as large again; costs
/// are per node, those of explicit schemes per node and explicit step. A configuration that diverged in one of them is
/// not taken.
///
/// can_run: of an integrator's name; what it refuses is left out.
///
/// Not good at: scenes unlike all that were measured (`why` names the nearest), and chaotic ones, in which no solver
/// keeps a percent for long.
SolverChoice choose_solver(
    const SceneFeatures& scene, const SolverWish& wish, const SolverTable& table,
    const std::function<bool(const std::string&)>& can_run = [](const std::string&) { return true; });

}  // namespace deformable_sim
