// The map of what is stable: two-dimensional slices through step size, stiffness, damping, mass ratio and mesh quality.
#pragma once

#include <string>
#include <vector>

#include "bench.h"
#include "deformable_sim/scene/progress.h"
#include "stability_limits.h"
#include "stability_run.h"
#include "work_precision_budget.h"

namespace deformable_sim::stability {

/// One column of a slice: a body somewhere, and what its cells are labelled with.
struct Column {
  std::string slice;  // stiffness, damping, mass_ratio, aspect
  std::string body;   // rope, sheet, solid, scene
  Point at;
};

/// Who takes the steps. scheme: as it is, with a linear solver (empty: it has none). world: a World with the named
/// integrator and everything else as a scene has it that says no more. auto: a World of a scene that says its step
/// alone; and "auto, any step" with that left open, too.
struct Stepper {
  enum class Way { kScheme, kWorld, kAuto, kAutoAnyStep };
  Way way = Way::kScheme;
  std::string integrator, linear_solver;
  std::string text() const;
};

struct Row {
  Column column;
  Stepper stepper;
  double dt = 0.0;     // s
  double limit = 0.0;  // s, of theory; infinity: none
  Outcome outcome;
  std::string chosen;      // auto: integrator and parts of a step
  double uncertain = 0.0;  // of the reference, over the size, at the last instant compared; NaN: unknown
};

struct Map {
  std::vector<Row> rows;
  std::vector<Limit> limits;
  int left_out = 0;  // cells the budget did not reach
};

/// What is gone through. A scene of the user's (not null) takes the place of the bodies: its stiffnesses are scaled.
struct Plan {
  std::vector<double> dts;
  std::vector<Column> columns;
  bool solvers = true;  // all linear solvers, or the first alone
  const SceneSpec* scene = nullptr;
};
Plan plan(study::Effort effort, const SceneSpec* scene);

/// Those that go through a column. Schemes by themselves in the rope's slices and the sheet's aspect.
std::vector<Stepper> steppers(const Plan& plan, const Column& column);

/// most: CPU s of a cell.
std::vector<Row> run_column(const Plan& plan, const Column& column, double most, const SolverTable& table);

/// Columns in turn until the budget is spent; then the limits of the explicit schemes (not with a scene).
Map make_map(const Plan& plan, const work_precision::Budget& budget, Progress* progress);

/// One line a cell.
std::string csv_of(const Map& map);
/// One line a measured limit.
std::string limits_csv_of(const Map& map);
/// For people: counts of the classes by who stepped, the limits, and every cell where the default solver is neither
/// right nor says so.
std::string text_of(const Map& map);

}  // namespace deformable_sim::stability
