// Construction, and what a part of a step is made of.
#include "deformable_sim/core/world.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include <time.h>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/integrator/sheet_stage.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

constexpr int kMaxWidenings = 4;

void check_settings(const WorldSettings& s) {
  if (!(s.dt >= kLeastStep && s.dt <= kLongestStep)) throw InputError("dt must be 1e-9 ... 2 s");
  if (s.parts < 1 || s.parts > kMaxParts) throw InputError("parts must be 1 ... " + std::to_string(kMaxParts));
  if (!std::isfinite(s.grasp_max_speed) || s.grasp_max_speed <= 0.0)
    throw InputError("grasp_max_speed must be > 0 m/s");
  if (!std::isfinite(s.collider_max_speed) || s.collider_max_speed <= 0.0)
    throw InputError("collider_max_speed must be > 0 m/s");
}

/// A contact between nodes couples them, whether a spring does or not.
void add_contact_pairs(const Model& model, std::vector<std::array<int, 2>>* pairs) {
  std::vector<ContactPoint> points;
  for (size_t b = 0; b < model.bodies.size(); ++b)
    if (model.bodies[b].contact_at_faces) add_between_points(model, static_cast<int>(b), &points);
  for (const ContactPoint& p : points)
    for (size_t i = 1; i < static_cast<size_t>(p.count); ++i)
      for (size_t j = 0; j < i; ++j) pairs->push_back({p.node[i], p.node[j]});
}

}  // namespace

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void check_scheme(const Integrator& scheme, const Model& model) {
  if (scheme.needs().lumped_mass && model.mass_matrix.nonZeros() > 0) {
    throw InputError("integrator " + scheme.name() + " needs lumped masses; a body here has mass: consistent");
  }
  if (takes_known_terms_only(scheme.name())) refuse_unknown_terms(scheme.name(), model.energies);
}

World::Parts::Parts(std::shared_ptr<const Model> shared_model, WorldSettings world_settings,
                    std::vector<Collider> colliders_in, std::vector<GraspRequest> grasps_in)
    : model(std::move(shared_model)),
      settings(std::move(world_settings)),
      initial_colliders(std::move(colliders_in)),
      initial_grasps(std::move(grasps_in)),
      grasps(model.get(), settings.grasp_max_speed),
      colliders(settings.collider_max_speed) {
  check_settings(settings);
  if (settings.threads != 1) workers = std::make_unique<Workers>(settings.threads);
  if (workers && workers->threads() > 1) dynamics.workers = workers.get();
  integrator = make_integrator(settings.integrator, settings.solver);
  dynamics.mass = &model->mass;
  if (model->mass_matrix.nonZeros() > 0) dynamics.mass_matrix = &model->mass_matrix;
  check_scheme(*integrator, *model);
  dynamics.grids = &model->grids;
  if (!model->strain_limits.empty()) limiter = std::make_unique<StrainLimiter>(*model);
  make_meetings();
  if (integrator->needs().jacobian) make_pattern();
  start();
}

void World::Parts::make_meetings() {
  size_t meeting = 0;
  bool alone = false;
  for (const Body& body : model->bodies) {
    if (body.touches != BodyContact::kNone) ++meeting;
    alone = alone || body.touches == BodyContact::kAll;
  }
  if (meeting < 2 && !alone) return;
  meetings = std::make_unique<BodyContacts>(model.get());
  dynamics.bodies_meet = meeting > 1;
  start_crosses = meetings->find_crossing(model->initial.x);
  if (!start_crosses.empty() && !settings.may_start_crossed) {
    throw InputError(start_crosses + " at the start; place them apart, or leave out touches for one of them");
  }
}

void World::Parts::make_pattern() {
  dynamics.pattern = &pattern;
  for (const auto& e : model->energies) dynamics.energies.push_back(e.get());
  // Stages of sheets on grids assemble nothing; only soft grasps ask for their nodes' blocks.
  if (settings.solver.linear == SolverSettings::Linear::kMultigrid && is_in_stages(settings.integrator) && !limiter &&
      sheets_fit(dynamics)) {
    pattern = BlockMatrix(model->node_count(), {}, model->point_count());
    return;
  }
  std::vector<std::array<int, 2>> pairs;
  const bool links_apart = integrator->needs().links_apart;
  const auto in_pattern = [&](const Energy& e) { return !links_apart || !stays_apart(e); };
  for (const auto& e : model->energies)
    if (in_pattern(*e)) e->add_pattern(&pairs);
  for (int j = 0; j < model->mass_matrix.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(model->mass_matrix, j); it; ++it)
      if (it.row() < j) pairs.push_back({static_cast<int>(it.row()), j});
  add_contact_pairs(*model, &pairs);
  if (limiter) limiter->springs()->add_pattern(&pairs);
  pattern = BlockMatrix(model->node_count(), pairs, model->point_count());
  for (const auto& e : model->energies)
    if (in_pattern(*e)) e->bind(pattern);
  if (limiter) limiter->springs()->bind(pattern);
}

void World::Parts::start() {
  state = model->initial;
  state.time = 0.0;
  step_count = 0;
  report = StepReport();
  substeps = 1;
  repeated = 0;
  sunk_until = 1;
  safe_until = 0.0;
  max_penetration = 0.0;
  book.forget();
  controller = nullptr;
  set_control(settings.control);
  limits_met = true;
  if (meetings) meetings->forget();
  failure.clear();
  cost = last_cost = CostWindow();
  grasps = GraspSet(model.get(), settings.grasp_max_speed);
  colliders = ColliderSet(settings.collider_max_speed);
  for (const Collider& c : initial_colliders) colliders.add(c);
  for (const GraspRequest& g : initial_grasps) grasps.add(g, state);
  colliders_changed();
  bind_terms();
}

void World::Parts::set_control(const StepControlSettings& control) {
  for (const double number : {control.error, control.budget, control.floor})
    if (!std::isfinite(number) || number <= 0.0) throw InputError("error, budget and floor of a control must be > 0");
  if (control.control == StepControl::kFixed) {
    controller = nullptr;
  } else if (controller) {
    controller->set(control);
  } else {
    controller = std::make_unique<StepController>(control);
  }
}

void World::Parts::held_nodes_changed(double stored) {
  book.change(grasps.stored_energy(state) - stored);
  bind_terms();
}

void World::Parts::bind_terms() {
  dynamics.energies.clear();
  for (const auto& e : model->energies) dynamics.energies.push_back(e.get());
  if (limiter && dynamics.pattern != nullptr) dynamics.energies.push_back(limiter->springs());
  for (TargetSprings* springs : grasps.springs()) {
    if (dynamics.pattern != nullptr) springs->bind(pattern);
    dynamics.energies.push_back(springs);
  }
  dynamics.kinematics = grasps.kinematics();
  roles.assign(static_cast<size_t>(model->node_count()), NodeRole::kFree);
  for (int node : dynamics.kinematics.node) roles[static_cast<size_t>(node)] = NodeRole::kHeld;
  for (const Body& body : model->bodies) {
    for (const StrainEdge& edge : body.strain_edges) {
      NodeRole& a = roles[static_cast<size_t>(edge.node[0])];
      NodeRole& b = roles[static_cast<size_t>(edge.node[1])];
      if (a == NodeRole::kHeld && b == NodeRole::kFree) b = NodeRole::kBesideHeld;
      if (b == NodeRole::kHeld && a == NodeRole::kFree) a = NodeRole::kBesideHeld;
    }
  }
  if (meetings) {
    inverse_mass = model->mass.cwiseInverse();
    for (int node : dynamics.kinematics.node) inverse_mass[node] = 0.0;
  }
  stable_dt_age = -1;
  if (controller) controller->hurry();
  if (state.x_before.cols() == 0) state.dt_before = 0.0;  // a node let go has another acceleration
  integrator->reset();
}

void World::Parts::colliders_changed() {
  sunk_until = step_count + 1;
  dynamics.contacts.clear();
  if (colliders.empty()) {
    contacts.reset();
    max_penetration = 0.0;
    return;
  }
  if (!contacts) contacts = std::make_unique<ContactFinder>(model.get());
  contacts->set_colliders(colliders.colliders());
}

double World::Parts::clock() const {
  return timed ? cpu_seconds() : 0.0;
}

void World::Parts::integrate(double h) {
  if (limiter) limiter->begin(h, dynamics.kinematics, &state);
  const double start = clock();
  const StepReport part = integrator->advance(h, &dynamics, &state);
  cost.integrate += clock() - start;
  if (timed) cost.assembly += part.seconds_assembly;
  if (timed) cost.solve += part.seconds_solve;
  add_report(part);
  if (limiter) limit_strain(h);
  for (const Energy* energy : dynamics.energies) energy->end_step(&state);
}

void World::Parts::limit_strain(double h) {
  if (!state.finite()) return;
  const double start = clock();
  for (ContactConstraint& c : dynamics.contacts) c.stuck -= contact_position(c, state.x);
  const StrainLimitReport found = limiter->project(h, &dynamics, &state);
  for (ContactConstraint& c : dynamics.contacts) {
    const bool touches = !c.force.isZero(0.0);
    c.stuck = touches ? stick_remainder(c, c.stuck + contact_position(c, state.x)) : Vec3::Zero();
  }
  cost.limits += clock() - start;
  limits_met = found.converged;
  excess = found.violation;
}

bool World::Parts::integrate_with_contacts(double h, const State& before) {
  double extra_reach = 0.0;
  for (int widening = 0;; ++widening) {
    double start = clock();
    dynamics.contacts.clear();
    if (contacts) contacts->find(state, h, collider_steps, roles, extra_reach, &dynamics.contacts);
    cost.contact += clock() - start;
    if (meetings) {
      start = clock();
      meetings->find(state, h, dynamics.kinematics.node, dynamics.kinematics.target, &dynamics.contacts);
      cost.meetings += clock() - start;
    }
    integrate(h);
    if (!state_is_sane()) return false;
    start = clock();
    const double missed = contacts ? contacts->missed_motion(before.x, state.x) : 0.0;
    cost.contact += clock() - start;
    if (missed == 0.0 || widening == kMaxWidenings) break;
    extra_reach += missed;
    state = before;
  }
  if (contacts) contacts->keep_stuck(dynamics.contacts, collider_steps);
  if (meetings) meetings->keep_stuck(dynamics.contacts);
  if (meetings) keep_bodies_apart(h, before);
  // After what puts bodies apart, which knows nothing of colliders.
  if (contacts) violation = std::max(violation, contacts->violation(state.x, dynamics.contacts));
  return true;
}

/// Moves grasps and colliders to where they are at the end of the part. Soft grasps do work in that moment.
void World::Parts::prescribe(double h) {
  const double start = clock();
  if (!grasps.empty()) {
    const double before = grasps.stored_energy(state);
    grasps.advance(h, state, &dynamics.kinematics);
    book.add(grasps.stored_energy(state) - before);
    book.begin_held(dynamics.kinematics, state.x);
  }
  if (!colliders.empty()) colliders.advance(h, &collider_steps);
  cost.grasps += clock() - start;
}

bool World::Parts::advance(double h, double fraction, const State& before) {
  if (!grasps.empty() || !colliders.empty()) prescribe(h);

  bool sane = false;
  if (contacts || meetings) {
    sane = integrate_with_contacts(h, before);
    book.add_colliders(dynamics.contacts, h);
  } else {
    integrate(h);
    sane = state_is_sane();
  }

  if (!grasps.empty()) {
    const double start = clock();
    grasps.measure(dynamics.kinematics, state, fraction);
    book.end_held(dynamics.kinematics, state.x);
    cost.grasps += clock() - start;
  }
  return sane;
}

World::World(std::shared_ptr<const Model> model, WorldSettings settings, std::vector<Collider> colliders,
             std::vector<GraspRequest> grasps)
    : parts_(std::make_unique<Parts>(std::move(model), std::move(settings), std::move(colliders), std::move(grasps))) {}
World::~World() = default;

void World::set_control(const StepControlSettings& control) {
  parts_->set_control(control);
}

double World::time() const {
  return parts_->state.time;
}
std::uint64_t World::step_count() const {
  return parts_->step_count;
}
const State& World::state() const {
  return parts_->state;
}
const Model& World::model() const {
  return *parts_->model;
}
std::shared_ptr<const Model> World::shared_model() const {
  return parts_->model;
}
const WorldSettings& World::settings() const {
  return parts_->settings;
}

}  // namespace deformable_sim
