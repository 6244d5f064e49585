#include "work_precision_plan.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/sheet_stage.h"
#include "work_precision_run.h"

namespace deformable_sim::work_precision {
namespace {

constexpr int kFrame = 60;                 // frames a second
constexpr double kOfLimit = 0.95;          // an explicit step, of the one that needs no division
constexpr double kConvergedLinear = 0.01;  // relative residual of cg in a converged solve
constexpr int kAmple = 20;                 // Newton iterations
constexpr int kManyIterations = 5000;
constexpr double kWorthSaving = 0.05;  // CPU s: a family whose runs cost less is shown whole
constexpr size_t kPatience = 2, kDivergences = 4;

// CPU s, of a Newton iteration: by node, and by node to the power 3/2. Only to begin with what is cheap.
constexpr double kCheap = 2e-7, kDear = 6e-6, kFactorised = 1e-6;
constexpr int kGuessedIterations = 8;

struct LinearSolver {
  const char* name;
  double tolerance;
  int iterations;
};
/// Those that suit the scene; the first is for everything that has a matrix. Quick: one variant of each.
std::vector<LinearSolver> solvers_for(const Case& c, study::Effort effort) {
  const bool quick = effort == study::Effort::kQuick;
  std::vector<LinearSolver> solvers{{"cg", 0.1, 200}, {"direct", 0.0, 0}};
  if (!quick) solvers.insert(solvers.end(), {{"cg", 0.1, 5}, {"cg", 0.01, 200}});
  if (c.features.kind == "rope") solvers.push_back({"banded", 0.0, 0});
  if (c.features.kind != "rope") {
    solvers.push_back({"multigrid", 0.1, 50});
    if (!quick) solvers.insert(solvers.end(), {{"multigrid", 0.3, 2}, {"multigrid", 0.1, 3}, {"multigrid", 0.01, 50}});
  }
  return solvers;
}

std::vector<int> unique(std::vector<int> ladder) {
  std::sort(ladder.begin(), ladder.end());
  ladder.erase(std::unique(ladder.begin(), ladder.end()), ladder.end());
  return ladder;
}

int steps_at(double rate, double quarter) {
  return std::max(1, static_cast<int>(std::ceil(quarter * rate - 1e-9)));
}

std::vector<int> rate_ladder(double quarter, study::Effort effort) {
  std::vector<int> ladder;
  const int coarsest = effort == study::Effort::kQuick ? kFrame : kFrame / 2,
            finest = effort == study::Effort::kQuick ? 480 : 3840;
  for (int rate = coarsest; rate <= finest; rate *= 2) ladder.push_back(steps_at(rate, quarter));
  return unique(ladder);
}

/// A frame, which the world divides, then steps below the limit. A scheme that divides steps itself has none.
std::vector<int> explicit_ladder(double quarter, double usable, study::Effort effort) {
  if (usable > 1.0 / kFrame) return rate_ladder(quarter, effort);
  std::vector<int> ladder{steps_at(kFrame, quarter)};
  const int least = std::max(ladder.front(), steps_at(1.0 / (kOfLimit * usable), quarter));
  for (int k = 0; k < (effort == study::Effort::kQuick ? 3 : 4); ++k) ladder.push_back(least << k);
  return unique(ladder);
}

std::vector<Configuration> implicit_configurations(const Case& c, const std::string& integrator, study::Effort effort) {
  std::vector<Configuration> all;
  const bool linearised = integrator == "linear_implicit_euler";
  for (const LinearSolver& solver : solvers_for(c, effort)) {
    Configuration k;
    k.integrator = integrator;
    k.linear_solver = solver.name;
    k.linear_tolerance = solver.tolerance;
    k.linear_iterations = solver.iterations;
    std::vector<int> newton = effort == study::Effort::kQuick ? std::vector<int>{1} : std::vector<int>{1, 2, 4};
    // The tolerance, not the number, ends these: one Newton step of a stiff rope leaves it frozen or torn.
    if (c.features.kind == "rope") newton.insert(newton.begin(), kAmple);
    if (linearised) newton = {c.features.contact ? 4 : 1};
    for (const int n : newton) {
      k.newton_iterations = n;
      all.push_back(k);
    }
  }
  if (linearised) return all;
  const bool rope = c.features.kind == "rope";
  for (const char* solver : {c.on_grid() ? "multigrid" : "cg", rope ? "banded" : "direct"}) {
    Configuration k;
    k.integrator = integrator;
    k.linear_solver = solver;
    k.newton_iterations = kConverged;
    if (k.linear_solver == "cg" || k.linear_solver == "multigrid") {
      k.linear_tolerance = kConvergedLinear;
      k.linear_iterations = kManyIterations;
    }
    all.push_back(k);
  }
  return all;
}

std::vector<Configuration> explicit_configurations(const Case& c, const std::string& integrator, study::Effort effort) {
  std::vector<Configuration> all(1);
  all[0].integrator = integrator;
  if (integrator != "substepped_verlet") return all;
  for (const char* precision : {"double", "single"}) {
    if (c.features.kind != "cloth" && std::string(precision) == "single") continue;
    for (const double fraction : {0.95, 0.6}) {
      if (fraction == 0.95 && std::string(precision) == "double") continue;
      if (effort == study::Effort::kQuick && fraction != 0.95) continue;
      all.push_back(all[0]);
      all.back().precision = precision;
      all.back().fraction = fraction;
    }
  }
  return all;
}

/// Of the schemes that know springs and quadratic bending only.
std::vector<Configuration> known_terms_configurations(const Case& c, const std::string& integrator,
                                                      study::Effort effort) {
  std::vector<Configuration> all;
  const bool quick = effort == study::Effort::kQuick;
  const bool global = integrator == "projective_dynamics";
  Configuration k;
  k.integrator = integrator;
  k.linear_solver = integrator == "line_dual" ? "lines" : global ? "constant" : "springs";
  std::vector<int> iterations = global ? std::vector<int>{4, 20} : std::vector<int>{1, 2, 4};
  if (quick) iterations.resize(1);
  for (const int n : iterations) {
    k.newton_iterations = n;
    k.precision = "double";
    all.push_back(k);
    if (global || quick || c.features.kind != "cloth") continue;
    k.precision = "single";
    all.push_back(k);
  }
  return all;
}

bool takes(const Case& c, const std::string& integrator) {
  try {
    c.make(1e-3, integrator, c.solver);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

bool diverged(const Row& row) {
  return row.status == Status::kDiverged;
}

/// Somebody else was at least as good, and far cheaper.
bool is_far_behind(const Row& row, const std::vector<Row>& all) {
  if (row.cpu_seconds < kWorthSaving) return false;
  return std::any_of(all.begin(), all.end(), [&row](const Row& other) {
    return other.status == Status::kDone && kFar * other.cost.cpu < row.cost.cpu &&
           (diverged(row) || other.errors.position <= row.errors.position);
  });
}

/// Stages a step.
int stages(const std::string& integrator) {
  return integrator == "tr_bdf2" ? 2 : 1;
}

bool at_most_as_dear(const Configuration& a, const Configuration& b) {
  return is_in_stages(a.integrator) == is_in_stages(b.integrator) && a.linear_solver == b.linear_solver &&
         a.precision == b.precision && a.steps == b.steps && a.newton_iterations <= b.newton_iterations &&
         stages(a.integrator) <= stages(b.integrator) && a.linear_iterations <= b.linear_iterations &&
         a.linear_tolerance >= b.linear_tolerance;
}

}  // namespace

UsableSteps usable_steps(const Case& c) {
  UsableSteps usable;
  for (const std::string& name : integrator_names()) {
    if (!make_integrator(name, {})->needs().jacobian && !takes_known_terms_only(name))
      usable[name] = usable_step(c, name);
  }
  return usable;
}

std::vector<Family> plan(const Case& c, const UsableSteps& usable, study::Effort effort) {
  std::vector<Family> families;
  for (const std::string& name : integrator_names()) {
    if (takes_known_terms_only(name)) {
      if (!takes(c, name)) continue;
      for (const Configuration& k : known_terms_configurations(c, name, effort)) {
        families.push_back({k, rate_ladder(c.quarter(), effort)});
      }
      continue;
    }
    const auto step = usable.find(name);
    if (step != usable.end()) {
      for (const Configuration& k : explicit_configurations(c, name, effort)) {
        families.push_back({k, explicit_ladder(c.quarter(), step->second, effort)});
      }
      continue;
    }
    for (const Configuration& k : implicit_configurations(c, name, effort)) {
      families.push_back({k, rate_ladder(c.quarter(), effort)});
    }
  }
  return families;
}

bool is_base(const Configuration& k) {
  return k.is_converged() || (k.integrator == "linear_implicit_euler" && k.linear_solver == "direct");
}

std::string reason_to_stop(const std::vector<Row>& family, const std::vector<Row>& all, double resolution) {
  if (family.empty()) return "";
  const Row& last = family.back();
  if (last.status == Status::kStopped) return last.note;
  if (last.status == Status::kDone && last.errors.position < resolution) {
    return "below what the reference can resolve";
  }
  const auto in_a_row = [&](size_t count, auto&& holds) {
    if (family.size() < count) return false;
    for (size_t k = family.size() - count; k < family.size(); ++k) {
      if (!holds(k)) return false;
    }
    return true;
  };
  if (in_a_row(kDivergences, [&](size_t k) { return diverged(family[k]); })) return "diverges";
  if (in_a_row(kPatience, [&](size_t k) { return is_far_behind(family[k], all); })) return "far behind others";
  const bool stuck = in_a_row(kPatience, [&](size_t k) {
    return k > 0 && !diverged(family[k]) && !diverged(family[k - 1]) &&
           family[k].errors.position > 0.9 * family[k - 1].errors.position;
  });
  return stuck ? "a smaller step does not help" : "";
}

double expected_cpu(const Configuration& k, const std::vector<Row>& rows) {
  double own = 0.0, related = 0.0;
  int nearest = 0;
  for (const Row& row : rows) {
    if (diverged(row)) continue;
    const Configuration& other = row.configuration;
    if (other.family() == k.family() && other.steps > nearest && other.steps <= k.steps) {
      nearest = other.steps;
      own = row.cpu_seconds * k.steps / other.steps;
    }
    if (!k.is_explicit() && at_most_as_dear(other, k)) related = std::max(related, row.cpu_seconds);
  }
  return own > 0.0 ? own : related;
}

double guessed_cpu(const Case& c, const Configuration& k) {
  const double nodes = c.features.nodes;
  const bool in_rows = k.linear_solver == "multigrid" && c.on_grid() && is_in_stages(k.integrator);
  const bool cheap = k.linear_solver == "banded" || in_rows;
  const double iteration =
      k.linear_solver == "direct" ? kFactorised * std::pow(nodes, 1.5) : (cheap ? kCheap : kDear) * nodes;
  return kQuarters * k.steps * stages(k.integrator) * std::min(k.newton_iterations, kGuessedIterations) * iteration;
}

}  // namespace deformable_sim::work_precision
