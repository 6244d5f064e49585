// One step and its guards: what is not accepted is made again, in shorter parts, then by the safe scheme.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "world_parts.h"

namespace deformable_sim {
namespace {

constexpr int kMaxHalvings = 6;
constexpr int kMostParts = 512;           // of a step with a matrix, unless it had a quarter as many before
constexpr double kFurthest = 1e6;         // m: beyond this a state counts as diverged
constexpr double kGrossResidual = 100.0;  // m/s^2: an implicit step this far off is tried again in two parts
constexpr double kDiverged = 1e6;         // m/s^2: such a step is no solution at all
constexpr double kViolation = 0.0005;     // m: contacts that end so far inside are tried again in shorter parts
constexpr double kLost = 0.005;           // m: the same, as often as it takes
constexpr int kMaxRefinements = 2;
constexpr double kHopeless = 0.02;      // m: what is deeper was put there, or thrown
constexpr std::uint64_t kGivenUp = 20;  // steps, in which nothing is done about what sinks
constexpr double kOverlap = 0.001;      // m: bodies this far inside a collider are let out, which takes work
constexpr double kUnsolvedGain = 0.05;  // of all energy, that a step which is no solution may err by
constexpr double kUnsolvedLift = 2e-4;  // J/kg: besides
constexpr double kExplicitGain = 0.25;  // the same, of an explicit one: the faster a mode the more its energy swings
constexpr double kExplicitLift = 0.02;
const char* const kSafeScheme = "implicit_euler";
constexpr int kSafeIterations = 30;

/// How the safe scheme tries a step: in how many parts, and by how much (m) the worst contact may give way in one, to
/// be put apart after it. Bodies that are jammed into one another give way by anything; they end apart, or do not move.
struct SafeTry {
  int parts;
  double violation;
};
constexpr int kShortestSafe = 64;
constexpr SafeTry kSafeTries[] = {{8, kLost}, {kShortestSafe, kLost}, {8, std::numeric_limits<double>::infinity()}};

void add(const StepReport& part, StepReport* sum) {
  sum->converged = sum->converged && part.converged;
  sum->newton_iterations += part.newton_iterations;
  sum->linear_iterations += part.linear_iterations;
  sum->force_evaluations += part.force_evaluations;
  // Not std::max, which loses a NaN.
  if (!(part.residual <= sum->residual)) sum->residual = part.residual;
  sum->seconds_assembly += part.seconds_assembly;
  sum->seconds_solve += part.seconds_solve;
}

/// RMS over nodes of how far a and b are apart, relative to the size of their body, in squares.
double squared_difference(const Model& model, const Nodes& a, const Nodes& b) {
  double sum = 0.0;
  for (const Body& body : model.bodies) {
    const auto of_body = [&body](const Nodes& x) { return x.middleCols(body.first_node, body.node_count); };
    const Nodes rest = of_body(model.initial.x);
    const double size = (rest.rowwise().maxCoeff() - rest.rowwise().minCoeff()).squaredNorm();
    sum += (of_body(a) - of_body(b)).squaredNorm() / size;
  }
  return sum / std::max(1, model.point_count());
}

}  // namespace

void World::Parts::add_report(const StepReport& part) {
  add(part, &report);
}

void World::Parts::keep_last_good() {
  good_state = state;
  grasps.save_motions(&good_grasps);
  good_colliders = colliders.motions();
  if (contacts) contacts->begin_step();
  if (meetings) meetings->begin_step();
  book.begin_step();
}

void World::Parts::restore_last_good() {
  state = good_state;
  grasps.restore_motions(good_grasps);
  colliders.restore_motions(good_colliders);
  if (contacts) contacts->restart_step();
  if (meetings) meetings->restart_step();
  book.restart_step();
}

bool World::Parts::state_is_sane() const {
  // An implicit step whose forces are not numbers leaves a finite state and a residual that is none. Of a scheme whose
  // unknowns are tensions a large one is no sign of divergence: stiffness times what is left to do.
  // Where bodies meet, shorter parts are judged by how far what is left would move a node, as whole steps are.
  const double shorter = meetings ? 1 << refinements : 1;
  // In the last resort the books of energy tell, and what contacts give way.
  const bool judged = integrator->needs().jacobian && !last_resort;
  const double most = judged ? kDiverged * shorter * shorter : std::numeric_limits<double>::max();
  // A sum is finite only where all that it sums is, and far quicker than a look at each.
  return std::isfinite(state.x.sum()) && std::isfinite(state.v.sum()) &&
         std::isfinite(dynamics.kinematics.reaction.sum()) && report.residual <= most &&
         state.x.cwiseAbs().maxCoeff() <= kFurthest;
}

/// Where even the last, shortest part would have bodies cross, nothing moves in it.
void World::Parts::keep_bodies_apart(double h, const State& before) {
  const double start = clock();
  violation = std::max(violation, BodyContacts::violation(before.x, state.x, dynamics.contacts));
  const double wanting = meetings->keep_apart(before.x, inverse_mass, h, &state);
  if (wanting > 0.0) violation = std::max(violation, kLost + wanting);
  if (wanting > 0.0 && is_shortest()) {
    state.x = before.x;
    state.v.setZero();
  }
  cost.meetings += clock() - start;
}

bool World::Parts::try_step(int parts) {
  report = StepReport();
  violation = 0.0;
  grasps.clear_wrenches();
  for (int i = 0; i < parts; ++i) {
    if (i > 0) part_state = state;
    if (!advance(settings.dt / parts, 1.0 / parts, i > 0 ? part_state : good_state)) return false;
  }
  makes_energy = max_penetration < kOverlap && (!book.is_possible(*model, state) || unsound_step_gains()) &&
                 depth_of_state() < kOverlap;
  return true;
}

/// What is left far from a solution may be anything: its elastic energy counts as well. So it does where an explicit
/// scheme evaluated forces so often that a look at all energies is cheap.
bool World::Parts::unsound_step_gains() {
  const bool unsolved = !report.converged && report.residual > kGrossResidual;
  const bool cheap = !integrator->needs().jacobian && book.is_look_cheap(report.force_evaluations);
  if (!unsolved && !cheap) return false;
  const Energy* ignored = limiter ? limiter->springs() : nullptr;
  return book.has_gained(*model, dynamics, ignored, state, unsolved ? kUnsolvedGain : kExplicitGain,
                         unsolved ? kUnsolvedLift : kExplicitLift);
}

/// Whether the parts of the present step are not halved any further.
bool World::Parts::is_shortest() const {
  return refinements >= kMaxHalvings ||
         (refinements >= kMaxRefinements && integrator->needs().jacobian && substeps >= kMostParts);
}

bool World::Parts::is_poor(int refinement) const {
  // What an implicit contact gives way shrinks with the square of the part. A point far behind its plane is about to be
  // lost on the other side: worth more.
  if (violation > kLost) return true;
  if (violation > kViolation || makes_energy) return refinement < kMaxRefinements;
  return refinement == 0 && integrator->needs().jacobian && !report.converged && report.residual > kGrossResidual;
}

/// From the last good state: a step in `substeps` parts, or more. False when there is none. Where bodies meet, a large
/// residual is no sign of divergence.
bool World::Parts::step_in_parts() {
  refinements = 0;
  bool ok = try_step(substeps);
  while (!is_shortest() && (!ok || is_poor(refinements))) {
    restore_last_good();
    substeps *= 2;
    if (!integrator->needs().jacobian && (!ok || makes_energy)) {
      // What is stable was measured elsewhere.
      stable_dt_age = -1;
      if (ok) integrator->reset();
      substeps = std::max(substeps, wanted_parts());
    }
    ++refinements;
    ok = try_step(substeps);
  }
  return ok;
}

/// The same step in parts and in twice as many, whose state is taken: what they differ by is what the first had wrong.
bool World::Parts::step_twice() {
  const bool coarse = try_step(substeps);
  coarse_x = state.x;
  coarse_v = state.v;
  restore_last_good();
  substeps *= 2;
  if (!step_in_parts()) return false;
  double apart = std::numeric_limits<double>::infinity();
  if (coarse) {
    apart = squared_difference(*model, coarse_x, state.x) +
            StepController::kCarried * StepController::kCarried * squared_difference(*model, coarse_v, state.v);
  }
  controller->checked(std::sqrt(apart), settings.dt, integrator->order_with_velocity_forces());
  return true;
}

double World::Parts::depth_of_state() {
  return contacts ? contacts->penetration(state.x, collider_steps, dynamics.contacts) : 0.0;
}

/// From the last good state, where the scene's scheme has found no step: implicit Euler with Newton's method given
/// time, which loses energy but little else can upset. False when there is none either, or none that ends at most
/// `depth` (m) inside a collider.
bool World::Parts::step_safely(double depth) {
  SolverSettings solver;
  solver.newton_iterations = kSafeIterations;
  solver.tolerance = settings.solver.tolerance;
  std::unique_ptr<Integrator> scheme = make_integrator(kSafeScheme, solver);
  std::swap(scheme, integrator);
  const WorldSettings asked = settings;
  settings.integrator = kSafeScheme;
  settings.solver = solver;
  make_pattern();
  bind_terms();
  bool ok = false;
  last_resort = true;
  for (const auto& [parts, most_violation] : kSafeTries) {
    restore_last_good();
    // The scheme's own memory is of no use to another.
    state.x_before.resize(3, 0);
    state.v_before.resize(3, 0);
    state.dt_before = 0.0;
    substeps = parts;
    refinements = kMaxHalvings;  // what would cross stays where it is
    ok = try_step(parts) && depth_of_state() <= depth &&
         (report.residual <= kDiverged || (book.is_possible(*model, state) && violation <= most_violation));
    if (ok) break;
  }
  last_resort = false;
  std::swap(scheme, integrator);
  settings = asked;
  dynamics.pattern = nullptr;
  if (integrator->needs().jacobian) make_pattern();
  const ContactConstraints touched = dynamics.contacts;
  const Kinematics held = dynamics.kinematics;
  bind_terms();
  dynamics.kinematics = held;
  dynamics.contacts = touched;
  if (ok) {
    safe_until = good_state.time + settings.dt + kRemembered;
    book.hurry();
  }
  return ok;
}

/// From the last good state: by the scene's scheme, or by the safe one where that finds none, what it left unsolved
/// makes energy, as an explicit one may, or points sink into colliders, step by step. Where bodies do not meet, a step
/// that makes energy is better than none, and told; so is one that sinks.
bool World::Parts::step_somehow() {
  constexpr double kAnywhere = std::numeric_limits<double>::infinity();
  const bool made = controller && controller->is_check_due() ? step_twice() : step_in_parts();
  if (!made) return step_safely(kAnywhere);
  const bool gains = makes_energy && !(report.converged && integrator->needs().jacobian);
  const double depth = depth_of_state(), bearable = std::max(kLost, max_penetration);
  const bool sinks = depth > bearable && depth < kHopeless && step_count >= sunk_until;
  if (!gains && !sinks) return true;
  const int parts = substeps, begun = refinements;
  const double better = sinks ? depth - kViolation : max_penetration;
  const bool safe = step_safely(gains && meetings ? kAnywhere : better);
  // A body between colliders that leave it no room sinks whatever is done.
  if (sinks && !(depth_of_state() <= bearable)) sunk_until = step_count + kGivenUp;
  if (safe) return true;
  if (gains && meetings) return false;
  restore_last_good();
  substeps = parts;
  refinements = begun;
  return try_step(parts);
}

/// The step is made: what it says of itself.
void World::Parts::accept_step() {
  // From the count, so that a stamp does not carry the rounding of all steps before it.
  ++step_count;
  state.time = static_cast<double>(step_count) * settings.dt;
  if (contacts) max_penetration = depth_of_state();
  if (refinements > 0) {
    ++repeated;
    if (controller) controller->hurry();
  }
  book.end_step(*model, dynamics, limiter ? limiter->springs() : nullptr, state, settings.dt, report.force_evaluations);
  if (grasps.empty()) return;
  const double stored = grasps.stored_energy(state);
  if (grasps.slip_overloaded()) held_nodes_changed(stored);
}

/// No step could be made: the world stays at its last good state, and nothing of the failed attempts is reported, whose
/// forces need not be finite.
std::string World::Parts::refuse_step() {
  restore_last_good();
  char text[200];
  std::snprintf(
      text, sizeof text,
      "no finite state at t = %.6g s, even with steps of %.3g s: forces too stiff for %s, or an impossible command",
      state.time + settings.dt, settings.dt / std::max(substeps, kShortestSafe), integrator->name().c_str());
  report = StepReport();
  report.converged = false;
  grasps.clear_wrenches();
  dynamics.contacts.clear();
  return text + turned_by_grasps();
}

/// Which bodies the grasps are about to turn inside out, where their law has no energy: in a cell that they hold by all
/// its corners, or within the shortest part of the step that was tried. Empty: none.
std::string World::Parts::turned_by_grasps() {
  if (dynamics.kinematics.node.empty()) return "";
  Kinematics held = dynamics.kinematics;
  grasps.advance(settings.dt, state, &held);
  const Nodes here = state.x;
  Nodes there = here;
  for (size_t k = 0; k < held.node.size(); ++k) there.col(held.node[k]) = held.target.col(static_cast<Eigen::Index>(k));
  const auto energies_at = [&](const Nodes& x) {
    std::vector<BodyReport> reports(model->bodies.size());
    state.x = x;
    add_elastic_energies(&reports);
    return reports;
  };
  const std::vector<BodyReport> soon = energies_at(here + (there - here) / kShortestSafe), then = energies_at(there);
  state.x = here;
  grasps.restore_motions(good_grasps);

  const auto turns_held_cell = [&](const Body& body) {
    return std::any_of(body.volume->tets.begin(), body.volume->tets.end(), [&](const auto& tet) {
      const auto at = [&](size_t k) { return Vec3(there.col(body.first_node + tet[k])); };
      for (size_t k = 0; k < 4; ++k)
        if (roles[static_cast<size_t>(body.first_node + tet[k])] != NodeRole::kHeld) return false;
      return (at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) <= 0.0;
    });
  };
  for (size_t b = 0; b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    if (!body.volume || std::isfinite(then[b].elastic_energy)) continue;
    if (!std::isfinite(soon[b].elastic_energy) || turns_held_cell(body))
      return "; grasps turn cells of '" + body.name +
             "' inside out, where its law has no energy: move them less or slower, or take stable_neo_hookean";
  }
  return "";
}

StepOutcome World::step() {
  Parts& w = *parts_;
  const Workers::Shift shift(w.dynamics.workers);
  w.timed = w.model->node_count() >= kSmallWorld || w.step_count % kTimedSteps == 0;
  const double spent = w.cost.total();
  w.keep_last_good();
  w.substeps = w.wanted_parts();
  const bool ok = w.step_somehow();

  StepOutcome outcome;
  outcome.ok = ok;
  outcome.report = w.report;
  w.failure.clear();
  if (!ok) {
    outcome.message = w.failure = w.refuse_step();
    return outcome;
  }
  if (w.controller) w.controller->stepped(w.timed ? (w.cost.total() - spent) / w.settings.dt : 0.0);
  w.accept_step();
  if (w.timed && ++w.cost.steps == CostWindow::kSteps) {
    w.last_cost = w.cost;
    w.cost = CostWindow();
  }
  return outcome;
}

}  // namespace deformable_sim
