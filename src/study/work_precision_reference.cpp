#include "work_precision_reference.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace deformable_sim::work_precision {
namespace {

constexpr int kMostExtrapolations = 2;
constexpr double kMainShare = 0.65;  // of the CPU time, the rest is for the check
constexpr int kHalvingsPlanned = 3;  // that must be affordable for a scheme to be chosen
constexpr double kTightest = 1e-9;   // m/s^2
constexpr int kFirstImplicit = 240;  // steps a second
constexpr int kDirectNodes = 200;    // up to which a sheet or solid is factorised
constexpr int kFewestSteps = 4;
constexpr double kPartsOfStep = 16.0;  // of Verlet by kernels, before what is done once a step is forgotten

Configuration implicit(const Case& c, const std::string& integrator) {
  Configuration k;
  k.integrator = integrator;
  const bool rope = c.features.kind == "rope";
  k.linear_solver = rope ? "banded" : c.features.nodes <= kDirectNodes ? "direct" : c.on_grid() ? "multigrid" : "cg";
  k.newton_iterations = kConverged;
  if (k.linear_solver == "cg" || k.linear_solver == "multigrid") {
    k.linear_tolerance = 1e-4;
    k.linear_iterations = 20000;
  }
  k.steps = std::max(kFewestSteps, static_cast<int>(std::ceil(c.quarter() * kFirstImplicit)));
  return k;
}

/// Explicit, at the largest step it can use.
Configuration explicit_scheme(const Case& c, const std::string& integrator) {
  Configuration k;
  k.integrator = integrator;
  k.steps = std::max(kFewestSteps, static_cast<int>(std::ceil(c.quarter() / usable_step(c, integrator))));
  return k;
}

/// Verlet by the kernels of sheets: on grids thirty times cheaper a step than Runge-Kutta, of the second order only.
Configuration verlet_scheme(const Case& c, double verlet_step) {
  Configuration k;
  k.integrator = "substepped_verlet";
  k.steps = std::max(kFewestSteps, static_cast<int>(std::ceil(c.quarter() / (kPartsOfStep * verlet_step))));
  return k;
}

/// The step, and with it the parts of one that is divided.
void halve(Configuration* k) {
  k->steps *= 2;
  if (k->integrator == "substepped_verlet") k->fraction *= 0.5;
}

bool affordable(const Case& c, const Configuration& k, double most) {
  const Run probe = run(c, k, kTightest, std::max(0.2, 0.02 * most));
  if (probe.status == Status::kDiverged) return false;
  return probe.cost.cpu * c.seconds * (std::exp2(kHalvingsPlanned) - 1.0) < most;
}

std::string describe(const std::string& scheme, const Refinement& r, double quarter) {
  if (r.steps == 0) return scheme + ": the budget did not suffice for one run";
  char text[160];
  std::snprintf(text, sizeof text, "%s, step halved %d times to %.3g s%s", scheme.c_str(),
                static_cast<int>(r.halvings.size()), quarter / r.steps,
                r.extrapolations > 0 ? ", extrapolated to the step zero" : "");
  return text + (r.stopped.empty() ? std::string() : "; " + r.stopped);
}

std::string reached_text(double reached) {
  char text[40];
  std::snprintf(text, sizeof text, "%.2g", reached);
  return text;
}

}  // namespace

Trajectory extrapolated(const Trajectory& a, const Trajectory& b, int order) {
  const double share = 1.0 / (std::exp2(order) - 1.0);
  Trajectory out = a;
  for (size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    out[k].x += share * (a[k].x - b[k].x);
    out[k].kinetic += share * (a[k].kinetic - b[k].kinetic);
    out[k].stored += share * (a[k].stored - b[k].stored);
    if (a[k].pull.cols() == b[k].pull.cols()) out[k].pull += share * (a[k].pull - b[k].pull);
  }
  return out;
}

Refinement refine(const Case& c, const Yardstick& yardstick, Configuration configuration, int order, double tight,
                  double goal, double most) {
  Refinement found;
  double left = most, last = 0.0;
  std::vector<Trajectory> before;  // of the step before: the run, its extrapolations
  while (found.stopped.empty()) {
    if (2.0 * last > left) {
      found.stopped = "the budget ended it";
      break;
    }
    const Run now = run(c, configuration, tight, left);
    last = now.cpu_seconds;
    left -= last;
    if (now.status == Status::kStopped) {
      found.stopped = "the budget ended it";
      break;
    }
    if (now.status == Status::kDiverged) {
      before.clear();
      halve(&configuration);
      continue;
    }
    std::vector<Trajectory> row{now.trajectory};
    const size_t columns = std::min<size_t>(before.size(), kMostExtrapolations);
    for (size_t k = 0; k < columns; ++k) {
      row.push_back(extrapolated(row[k], before[k], order + static_cast<int>(k)));
    }
    found.steps = configuration.steps;
    if (before.empty()) found.best = row.front();
    double least = kNone;
    for (size_t k = 0; k < std::min(before.size(), row.size()); ++k) {
      const double difference = yardstick.position(row[k], before[k]);
      if (k > 0 && !(difference < least)) continue;
      least = difference;
      found.best = row[k];
      found.extrapolations = static_cast<int>(k);
    }
    if (!before.empty()) {
      found.reached = least;
      found.halvings.push_back({now.dt, least});
      if (least < goal) return found;
    }
    before = std::move(row);
    halve(&configuration);
  }
  return found;
}

Reference find_reference(const Case& c, const Yardstick& yardstick, double verlet_step, double most,
                         Progress* progress) {
  const Budget budget(most);
  const double tight = tight_tolerance(c, verlet_step, kTightest);
  const Configuration rk4 = explicit_scheme(c, "rk4");
  const bool use_rk4 = !c.features.strain_limits && affordable(c, rk4, kMainShare * most);
  const Configuration verlet = verlet_scheme(c, verlet_step);
  const bool use_verlet =
      !use_rk4 && c.features.kind == "cloth" && !c.features.strain_limits && affordable(c, verlet, kMainShare * most);
  const bool is_explicit = use_rk4 || use_verlet;
  const Configuration main = use_rk4 ? rk4 : use_verlet ? verlet : implicit(c, "tr_bdf2");
  const Configuration other = implicit(c, is_explicit ? "tr_bdf2" : "bdf2");

  progress->show("reference by " + main.family(), 0.0, most);
  const Refinement first =
      refine(c, yardstick, main, use_rk4 ? 4 : 2, tight, kReferenceGoal, kMainShare * most - budget.spent());
  Reference reference;
  reference.trajectory = first.best;
  reference.reached = first.reached;
  reference.method = describe(main.integrator, first, c.quarter());
  reference.halvings = first.halvings;
  progress->say("reference: " + reference.method + "; converged to " + reached_text(first.reached));

  const Trajectory table = c.table();
  if (!table.empty()) {
    reference.trajectory = table;
    reference.check_method = reference.method;
    reference.check_reached = reference.reached;
    reference.check_difference = reference.reached = yardstick.position(first.best, table);
    reference.method = "golden table";
    return reference;
  }
  progress->show("check by " + other.family(), budget.spent(), budget.left());
  const Refinement second =
      refine(c, yardstick, other, 2, tight, std::max(kReferenceGoal, first.reached), budget.left());
  reference.check_method = describe(other.integrator, second, c.quarter());
  reference.check_reached = second.reached;
  reference.check_difference = yardstick.position(second.best, first.best);
  progress->say("check:     " + reference.check_method + "; converged to " + reached_text(second.reached) +
                ", differs by " + reached_text(reference.check_difference));
  return reference;
}

}  // namespace deformable_sim::work_precision
