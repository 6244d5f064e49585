#include "stability_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/stage_solver.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim::stability {
namespace {

constexpr double kMostPerCell = 0.3, kMostPerReference = 12.0;  // CPU s
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<double> decades(int from, int to, int a_decade) {
  std::vector<double> values;
  for (int k = from * a_decade; k <= to * a_decade; ++k) {
    values.push_back(std::pow(10.0, static_cast<double>(k) / a_decade));
  }
  return values;
}

constexpr double kBaseStiffness = 1e7, kMassStiffness = 1e9, kSheetStiffness = 1e6;  // Pa

void add_columns(const std::string& slice, const std::string& body, const std::vector<double>& values,
                 double Point::*axis, Point base, std::vector<Column>* columns) {
  for (const double value : values) {
    base.*axis = value;
    columns->push_back({slice, body, base});
  }
}

SolverSettings scheme_settings(const Stepper& stepper, bool rope) {
  SolverConfiguration k;
  k.linear_solver = stepper.linear_solver;
  k.newton_iterations = 20;
  SolverSettings settings = k.linear_solver.empty() ? SolverSettings{} : settings_of(k, {}, rope);
  if (k.linear_solver.empty()) settings.newton_iterations = 20;
  return settings;
}

/// A scene of this body that leaves its solver open, but for the step (0: that as well).
SceneSpec open_scene(const Subject& subject, double dt) {
  SceneSpec spec = subject.spec;
  spec.step.mode = SolverMode::kAuto;
  spec.step.dt_given = dt > 0.0;
  if (dt > 0.0) spec.step.dt = dt;
  return spec;
}

/// Everything that the cells of one column share.
struct Shared {
  Subject subject;
  SceneFeatures features;
  Fastest fastest;
  bool rope = false;
};

struct Chosen {
  WorldSettings settings;
  double expected = 0.0;
  std::string text;
};

Chosen choose(const Shared& shared, double dt, const SolverTable& table) {
  const SceneSpec spec = open_scene(shared.subject, dt);
  const SolverChoice choice = choose_for(spec, *shared.subject.model, shared.features, table);
  Chosen chosen{settings_for(spec, &choice), choice.guessed ? kNone : choice.error, ""};
  chosen.text = choice.configuration.text() + ", " + std::to_string(choice.parts) + " parts";
  return chosen;
}

/// The fastest motion is the most damped one here, too: dampers follow the stiffness, and drag is the same for all.
double limit_of(const Stepper& stepper, const Shared& shared) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (stepper.way != Stepper::Way::kScheme || !(shared.fastest.omega > 0.0)) return kNever;
  const double ratio = 0.5 * shared.fastest.rate / shared.fastest.omega;
  return make_integrator(stepper.integrator, {})->stability_limit(ratio) / shared.fastest.omega;
}

Outcome run_cell(const Stepper& stepper, const Shared& shared, double dt, const Reference& reference, double most,
                 const SolverTable& table, std::string* chosen) {
  if (stepper.way == Stepper::Way::kScheme) {
    const SolverSettings settings = scheme_settings(stepper, shared.rope);
    return run_scheme(shared.subject, stepper.integrator, settings, dt, reference, most);
  }
  if (stepper.way == Stepper::Way::kWorld) {
    SceneSpec spec = shared.subject.spec;
    spec.step.dt = dt;
    spec.step.integrator = stepper.integrator;
    return run_world(shared.subject, settings_for(spec, nullptr), 0.0, reference, most);
  }
  const bool any = stepper.way == Stepper::Way::kAutoAnyStep;
  const Chosen choice = choose(shared, any ? 0.0 : dt, table);
  *chosen = choice.text;
  return run_world(shared.subject, choice.settings, choice.expected, reference, most);
}

Subject subject_of(const Plan& plan, const Column& column) {
  return plan.scene != nullptr ? make_scaled(*plan.scene, column.at) : make_subject(column.body, column.at);
}

}  // namespace

std::string Stepper::text() const {
  switch (way) {
    case Way::kScheme:
      return linear_solver.empty() ? integrator : integrator + ", " + linear_solver;
    case Way::kWorld:
      return "world: " + integrator;
    case Way::kAuto:
      return "world: auto";
    case Way::kAutoAnyStep:
      break;
  }
  return "world: auto, any step";
}

Plan plan(study::Effort effort, const SceneSpec* scene) {
  const bool quick = effort == study::Effort::kQuick;
  Plan plan;
  plan.scene = scene;
  plan.solvers = !quick && scene == nullptr;
  plan.dts = quick ? std::vector<double>{1e-6, 1e-4, 1e-2, 1.0} : decades(-6, 0, 2);
  plan.dts.push_back(kLongest);
  if (scene != nullptr) {
    Point base;
    add_columns("stiffness", "scene", decades(quick ? -2 : -4, quick ? 2 : 4, 1), &Point::stiffness, base,
                &plan.columns);
    return plan;
  }
  const std::vector<double> moduli = quick ? std::vector<double>{1e2, 1e7, 1e12} : decades(2, 12, 1);
  const std::vector<double> dampings =
      quick ? std::vector<double>{0.0, 1e-3, 1.0} : std::vector<double>{0.0, 1e-5, 1e-4, 5e-4, 1e-3, 1e-2, 1e-1, 1.0};
  const std::vector<double> ratios = quick ? std::vector<double>{1.0, 1e6} : decades(0, 6, 1);
  const std::vector<double> aspects =
      quick ? std::vector<double>{1.0, 1000.0} : std::vector<double>{1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};
  Point base, heavy, sheet;
  base.stiffness = kBaseStiffness;
  heavy.stiffness = kMassStiffness;
  sheet.stiffness = kSheetStiffness;
  add_columns("stiffness", "rope", moduli, &Point::stiffness, base, &plan.columns);
  add_columns("damping", "rope", dampings, &Point::damping, base, &plan.columns);
  add_columns("mass_ratio", "rope", ratios, &Point::mass_ratio, heavy, &plan.columns);
  add_columns("aspect", "sheet", aspects, &Point::aspect, sheet, &plan.columns);
  add_columns("stiffness", "sheet", moduli, &Point::stiffness, base, &plan.columns);
  add_columns("stiffness", "solid", moduli, &Point::stiffness, base, &plan.columns);
  return plan;
}

std::vector<Stepper> steppers(const Plan& plan, const Column& column) {
  using Way = Stepper::Way;
  std::vector<Stepper> all{{Way::kAutoAnyStep, "", ""}, {Way::kAuto, "", ""}};
  const bool main_slice = column.slice == "stiffness" && column.body != "solid" && column.body != "sheet";
  if (main_slice) {
    for (const std::string& name : integrator_names()) all.push_back({Way::kWorld, name, ""});
  }
  if (column.slice == "stiffness" && !main_slice) return all;
  for (const std::string& name : integrator_names()) {
    if (!make_integrator(name, {})->needs().jacobian || takes_known_terms_only(name)) {
      all.push_back({Way::kScheme, name, ""});
      continue;
    }
    std::vector<std::string> solvers{"direct"};
    if (plan.solvers) solvers.insert(solvers.end(), {"cg", "banded"});
    // The others take conjugate gradients where multigrid is asked for.
    if (plan.solvers && is_in_stages(name)) solvers.emplace_back("multigrid");
    for (const std::string& solver : solvers) all.push_back({Way::kScheme, name, solver});
  }
  return all;
}

std::vector<Row> run_column(const Plan& plan, const Column& column, double most, const SolverTable& table) {
  Shared shared{subject_of(plan, column), {}, {}};
  shared.features = features_of(shared.subject.spec, *shared.subject.model);
  shared.fastest = fastest_of(shared.subject);
  shared.rope = shared.subject.spec.bodies.front().kind == BodyKind::kRope;
  std::vector<double> dts = plan.dts;
  const double any = choose(shared, 0.0, table).settings.dt;
  dts.push_back(any);
  const Reference reference(shared.subject, dts, kMostPerReference);
  std::vector<Row> rows;
  for (const Stepper& stepper : steppers(plan, column)) {
    if (stepper.way == Stepper::Way::kScheme && !shared.subject.has_scheme_alone) continue;
    const bool open = stepper.way == Stepper::Way::kAutoAnyStep;
    for (const double dt : open ? std::vector<double>{any} : plan.dts) {
      Row row{column, stepper, dt, limit_of(stepper, shared), {}, "", kNone};
      row.outcome = run_cell(stepper, shared, dt, reference, most, table, &row.chosen);
      if (const Reference::Instant* last = reference.at(instant(dt, kQuarters)); last != nullptr) {
        row.uncertain = last->uncertain / shared.subject.size;
      }
      rows.push_back(row);
    }
  }
  return rows;
}

Map make_map(const Plan& plan, const work_precision::Budget& budget, Progress* progress) {
  Map map;
  const SolverTable table = read_solver_table(solver_table_file());
  if (plan.scene == nullptr) {
    for (const std::string body : {"rope", "sheet"}) {
      for (const std::string& name : limited_schemes()) {
        for (const double ratio : {0.0, 0.1, 0.5, 1.0, 2.0}) map.limits.push_back(measure_limit(body, name, ratio));
      }
    }
  }
  size_t done = 0;
  for (const Column& column : plan.columns) {
    const double share = static_cast<double>(done) / static_cast<double>(plan.columns.size());
    progress->show(column.body + ", " + column.slice, share * budget.total(), (1.0 - share) * budget.total());
    ++done;
    if (budget.left() <= 0.0) {
      map.left_out += static_cast<int>(steppers(plan, column).size() * plan.dts.size());
      continue;
    }
    const std::vector<Row> rows = run_column(plan, column, kMostPerCell, table);
    map.rows.insert(map.rows.end(), rows.begin(), rows.end());
  }
  return map;
}

}  // namespace deformable_sim::stability
