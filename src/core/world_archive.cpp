// Saved states of a world, and which world they belong to.
#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>

#include "deformable_sim/core/archive.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

/// Changes with what a saved state is made of.
constexpr int kLayout = 1;
constexpr double kFurthest = 1e6;  // m

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

/// A state at which every force of the model shows: stretched a little, bent and moving, the same each time.
State probe_of(const Model& model) {
  State s = model.initial;
  for (Eigen::Index i = 0; i < s.x.size(); ++i) {
    s.x.data()[i] *= 1.0 + 0.01 * std::sin(12.9898 * static_cast<double>(i + 1));
    s.v.data()[i] = std::sin(78.233 * static_cast<double>(i + 1));
  }
  return s;
}

std::string text_of(const SolverSettings& s) {
  std::ostringstream text;
  text.precision(9);
  text << "linear solver " << static_cast<int>(s.linear) << ", " << s.newton_iterations << " iterations to "
       << s.tolerance << " m/s^2, linear " << s.linear_iterations << " to " << s.linear_tolerance << ", precision "
       << static_cast<int>(s.precision) << ", " << s.fraction_of_limit << " of the limit, matrix "
       << static_cast<int>(s.jacobian);
  return text.str();
}

/// What a world is made of, in words: two worlds for which they agree take one another's states. Forces to six digits,
/// which processors agree on.
std::vector<std::string> identity_of(const Model& model, const WorldSettings& settings) {
  std::vector<std::string> lines;
  for (const Body& b : model.bodies)
    lines.push_back("body " + b.name + " of " + std::to_string(b.node_count) + " nodes, friction " +
                    format("%.9g", b.friction) + ", contact radius " + format("%.9g m", b.contact_radius) +
                    ", touching " + std::to_string(static_cast<int>(b.touches)));
  lines.push_back(std::to_string(model.angle_count) + " angles");
  lines.push_back("mass " + format("%.9g kg", model.mass.sum()));
  lines.push_back(std::to_string(model.strain_limits.size()) + " strain limits");
  const State probe = probe_of(model);
  for (const auto& e : model.energies) {
    Nodes f = Nodes::Zero(3, model.node_count());
    e->add_force(probe, &f);
    lines.push_back(e->name() + " of " + std::to_string(e->element_count()) + " parts, " +
                    format("%.6g N at the probe", f.norm()));
  }
  lines.push_back("integrator " + settings.integrator + ", step " + format("%.9g s", settings.dt) + " in " +
                  std::to_string(settings.parts) + " parts");
  lines.push_back(text_of(settings.solver));
  lines.push_back("speeds " + format("%.9g", settings.grasp_max_speed) +
                  format(", %.9g m/s", settings.collider_max_speed));
  return lines;
}

void pass_identity(const std::vector<std::string>& here, Archive* archive) {
  int layout = kLayout;
  archive->pass(&layout);
  if (layout != kLayout) Archive::refuse("of another version of this package");
  std::vector<std::string> there = here;
  archive->pass(&there);
  for (size_t k = 0; k < std::max(here.size(), there.size()); ++k) {
    const std::string mine = k < here.size() ? here[k] : "nothing", its = k < there.size() ? there[k] : "nothing";
    if (mine != its) Archive::refuse("of another scene: it has '" + its + "' where this one has '" + mine + "'");
  }
}

/// As many columns as there are in this world, or none where that may be.
void check_columns(Eigen::Index found, Eigen::Index wanted, bool may_be_none) {
  if (found != wanted && !(may_be_none && found == 0)) Archive::refuse("another number of nodes");
}

void pass_state(Archive* archive, Eigen::Index limits, State* s) {
  const Eigen::Index n = s->x.cols(), segments = s->directors.cols();
  archive->pass(&s->x);
  archive->pass(&s->v);
  archive->pass(&s->directors);
  archive->pass(&s->tangents);
  archive->pass(&s->reference_twists);
  archive->pass(&s->limit_tension);
  archive->pass(&s->x_before);
  archive->pass(&s->v_before);
  archive->pass(&s->dt_before);
  if (!archive->reads()) return;
  check_columns(s->x.cols(), n, false);
  check_columns(s->v.cols(), n, false);
  check_columns(s->directors.cols(), segments, false);
  check_columns(s->tangents.cols(), segments, false);
  check_columns(s->reference_twists.size(), segments, false);
  check_columns(s->limit_tension.size(), limits, true);
  check_columns(s->x_before.cols(), n, true);
  check_columns(s->v_before.cols(), n, true);
  if (s->x.cwiseAbs().maxCoeff() > kFurthest) Archive::refuse("positions beyond 1e6 m");
}

void pass_report(Archive* archive, StepReport* report) {
  archive->pass(&report->converged);
  archive->pass(&report->newton_iterations);
  archive->pass(&report->linear_iterations);
  archive->pass(&report->force_evaluations);
  archive->pass_any(&report->residual);
}

}  // namespace

void World::Parts::pass(Archive* archive) {
  if (!archive->looks_on()) {
    stable_dt_age = -1;
    integrator->reset();
  }
  if (identity.empty()) identity = identity_of(*model, settings);
  pass_identity(identity, archive);
  archive->pass(&step_count);
  if (step_count > (std::uint64_t{1} << 52)) Archive::refuse("more steps than can be");
  if (!archive->looks_on()) sunk_until = step_count + 1;
  colliders.pass(initial_colliders, archive);
  grasps.pass(archive);
  if (archive->reads()) {
    colliders_changed();
    bind_terms();
  }
  pass_state(archive, static_cast<Eigen::Index>(model->strain_limits.size()), &state);
  state.time = static_cast<double>(step_count) * settings.dt;
  if (contacts) contacts->pass(archive);
  if (meetings) meetings->pass(archive);
  pass_report(archive, &report);
  book.pass(archive);
  StepControlSettings control = controller ? controller->settings() : settings.control;
  archive->pass_enum(&control.control, StepControl::kBudget);
  archive->pass(&control.error);
  archive->pass(&control.budget);
  archive->pass(&control.floor);
  if (archive->reads()) set_control(control);
  if (controller) controller->pass(archive);
  archive->pass(&safe_until);
  archive->pass(&substeps);
  archive->pass(&max_penetration);
  archive->pass(&limits_met);
  archive->pass_any(&excess);
}

std::string World::save() {
  Archive archive;
  parts_->pass(&archive);
  return archive.bytes();
}

std::string World::copy() const {
  Archive archive = Archive::looking_on();
  parts_->pass(&archive);
  return archive.bytes();
}

void World::restore(const std::string& bytes) {
  Parts& now = *parts_;
  // Meshes of colliders that came later need not be built anew either.
  std::vector<Collider> initial = now.initial_colliders;
  auto fresh = std::make_unique<Parts>(now.model, now.settings, initial, now.initial_grasps);
  fresh->identity = now.identity;
  Archive archive(bytes);
  const std::vector<Collider>& present = now.colliders.colliders();
  fresh->initial_colliders.insert(fresh->initial_colliders.end(), present.begin(), present.end());
  fresh->pass(&archive);
  archive.end();
  fresh->initial_colliders = std::move(initial);
  parts_ = std::move(fresh);
}

}  // namespace deformable_sim
