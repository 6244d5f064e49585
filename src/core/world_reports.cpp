// What a World says about itself: snapshot and bill.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "deformable_sim/core/integrator/sheet_stage.h"
#include "deformable_sim/core/rod_frames.h"
#include "world_parts.h"

namespace deformable_sim {
namespace {

/// Body whose nodes a term couples, or -1: terms that couple none (gravity, mass damping) store no elastic energy.
int body_of(const Model& model, const Energy& energy) {
  std::vector<std::array<int, 2>> pairs;
  energy.add_pattern(&pairs);
  if (pairs.empty()) return -1;
  for (size_t b = 0; b < model.bodies.size(); ++b)
    if (pairs.front()[0] < model.bodies[b].first_node + model.bodies[b].node_count) return static_cast<int>(b);
  return -1;
}

/// sum += 1/2 v^T M v of the nodes from `first` on, J; bodies share no entry of a consistent mass matrix.
void add_kinetic_energy(const Model& model, int first, int count, const State& s, double* sum) {
  if (model.mass_matrix.nonZeros() == 0) {
    for (int i = first; i < first + count; ++i) *sum += 0.5 * model.mass[i] * s.v.col(i).squaredNorm();
    return;
  }
  for (int j = first; j < first + count; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(model.mass_matrix, j); it; ++it)
      *sum += 0.5 * it.value() * s.v.col(it.row()).dot(s.v.col(j));
}

/// All of a report but the elastic energy and the contacts.
void add_report(const Model& model, const Body& body, const State& s, BodyReport* report) {
  BodyReport& r = *report;
  add_kinetic_energy(model, body.first_node, body.node_count, s, &r.kinetic_energy);
  for (int i = body.first_node; i < body.first_node + body.node_count; ++i)
    r.potential_energy -= model.mass[i] * model.gravity.dot(s.x.col(i));
  if (body.first_segment >= 0) {
    add_kinetic_energy(model, model.point_count() + body.first_segment, body.line->segment_count(), s,
                       &r.kinetic_energy);
  }
  for (const StrainEdge& e : body.strain_edges) {
    const double strain = (s.x.col(e.node[1]) - s.x.col(e.node[0])).norm() / e.rest_length - 1.0;
    r.max_strain = std::max(r.max_strain, strain);
    r.min_strain = std::min(r.min_strain, strain);
  }
}

/// Contacts that carry a force, per body, and their share at each node.
void count_contacts(const Model& model, const ContactConstraints& contacts, Snapshot* s) {
  Nodes force;
  for (const ContactConstraint& c : contacts) {
    if (c.force.isZero(0.0)) continue;
    if (force.cols() == 0) force = Nodes::Zero(3, model.node_count());
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) force.col(c.node[k]) += c.weight[k] * c.force;
    for (size_t b = 0; b < model.bodies.size(); ++b) {
      const Body& body = model.bodies[b];
      const auto has = [&](int node) { return node >= body.first_node && node < body.first_node + body.node_count; };
      // The last node is of the other body where there are two.
      if (has(c.node[0]) || has(c.node[static_cast<size_t>(c.count) - 1])) ++s->bodies[b].contacts;
    }
  }
  s->contact_force = force.colwise().norm().transpose().cast<float>();
}

/// Material frames of rods with twist; nothing where there are none.
void copy_rod_frames(const Model& model, const State& s, Snapshot* snapshot) {
  if (model.angle_count == 0) return;
  snapshot->tangents = s.tangents;
  snapshot->directors.resize(3, s.directors.cols());
  snapshot->rods.resize(6, s.directors.cols());
  for (const Body& body : model.bodies) {
    if (body.first_segment < 0) continue;
    snapshot->rods.middleCols(body.first_segment, body.line->segment_count()) = rod_state(model, body, s);
    for (int k = 0; k < body.line->segment_count(); ++k)
      snapshot->directors.col(body.first_segment + k) = material_frame(model, body, s, k).col(0);
  }
}

/// CPU seconds of one evaluation of a term's force, to divide the measured cost of assembly between the terms.
double force_seconds(const Energy& energy, const State& s, Nodes* work) {
  const double start = cpu_seconds();
  energy.add_force(s, work);
  return cpu_seconds() - start;
}

/// "stretch springs" has so many "springs", "gravity" acts on so many "elements".
std::string counted(const std::string& name, int count) {
  const bool springs = name.size() >= 7 && name.compare(name.size() - 7, 7, "springs") == 0;
  return std::to_string(count) + (springs ? " springs" : " elements");
}

std::string percent(double strain) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100.0 * std::abs(strain));
  return text;
}

/// One line for each body beyond the strains its material's law holds for.
void warn_of_strain(const Model& model, const std::vector<BodyReport>& reports, std::vector<std::string>* warnings) {
  for (size_t b = 0; b < model.bodies.size(); ++b) {
    const auto& [low, high] = model.bodies[b].valid_strain;
    const bool stretched = reports[b].max_strain > high;
    if (!stretched && !(reports[b].min_strain < low)) continue;
    warnings->push_back("body " + model.bodies[b].name + (stretched ? " is stretched to " : " is compressed to ") +
                        percent(stretched ? reports[b].max_strain : reports[b].min_strain) + ", beyond the " +
                        percent(stretched ? high : low) + " its material law holds for");
  }
}

/// One line for each soft body with tetrahedra that are turned inside out, where some laws have no energy (neo_hookean
/// and mooney_rivlin with J <= 0).
void warn_of_inversion(const Model& model, const Nodes& x, const std::vector<BodyReport>& reports,
                       std::vector<std::string>* warnings) {
  for (size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (!body.volume) continue;
    int inverted = 0;
    for (const auto& t : body.volume->tets) {
      const auto at = [&](size_t k) -> Vec3 { return x.col(body.first_node + t[k]); };
      if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) <= 0.0) ++inverted;
    }
    const bool lawless = !std::isfinite(reports[b].elastic_energy);
    if (inverted == 0 && !lawless) continue;
    warnings->push_back("body " + body.name + " is turned inside out in " + std::to_string(inverted) + " of its " +
                        std::to_string(body.volume->tets.size()) + " tetrahedra" +
                        (lawless ? ", where its material law has no energy; stable_neo_hookean and corotational are "
                                   "safe there"
                                 : ""));
  }
}

/// Multigrid is of two kinds, and not known to all schemes.
std::string solver_name(const SolverSettings& settings, const Integrator& integrator, const Dynamics& d) {
  switch (settings.linear) {
    case SolverSettings::Linear::kDirect:
      return "direct";
    case SolverSettings::Linear::kBanded:
      return "banded";
    case SolverSettings::Linear::kMultigrid:
      if (integrator.needs().links_apart) return sheets_fit(d) ? "multigrid on grids" : "multigrid on aggregates";
      break;
    case SolverSettings::Linear::kConjugateGradient:
      break;
  }
  return "conjugate gradient";
}

/// Nothing for one thread; else on how many there was something to do.
std::string threads_text(const Workers* workers) {
  if (workers == nullptr) return "";
  const std::string all = std::to_string(workers->threads()) + " threads";
  return workers->have_shared() ? ", on " + all : ", on 1 of " + all + ": nothing to share";
}

// m/s^2, about gravity: fast slack cloth misses the Newton tolerance at most steps without showing; see ~status.
constexpr double kNotableResidual = 10.0;
constexpr double kNotableGain = 0.1;           // of the energy that moves, in a second
constexpr double kLeastEnergy = 1e-6;          // J: less is nothing
constexpr double kNotablePenetration = 0.002;  // m

}  // namespace

std::vector<std::string> World::Parts::warnings() const {
  std::vector<std::string> warnings = model->notes;
  char text[200];
  const bool safely = state.time < safe_until;
  if (std::isfinite(stable_dt) && substeps > 1 && !safely) {
    std::snprintf(text, sizeof text, "%s takes %d substeps of %.3g s to stay stable; implicit_euler does not need them",
                  integrator->name().c_str(), substeps, settings.dt / substeps);
    warnings.emplace_back(text);
  }
  if (integrator->stability_limit() == 0.0)
    warnings.push_back(integrator->name() +
                       " is unstable at any step unless damped; use symplectic_euler or implicit_euler");
  if (!limits_met) {
    std::snprintf(text, sizeof text,
                  "the strain limit is exceeded by %.3g: grasps or colliders stretch the body further than it allows",
                  excess);
    warnings.emplace_back(text);
  }
  if (safely) {
    warnings.push_back(integrator->name() +
                       " found no step; implicit_euler made it, which damps motion: a smaller step.dt mends it");
  }
  if (book.created_lately() > kNotableGain * book.scale() && book.created_lately() > kNotableGain * kLeastEnergy) {
    std::snprintf(text, sizeof text,
                  "energy from nowhere: %.3g J in the last second, where %.3g J move; a smaller step.dt mends it",
                  book.created_lately(), book.scale());
    warnings.emplace_back(text);
  }
  if (max_penetration > kNotablePenetration) {
    std::snprintf(text, sizeof text, "a contact point is %.3g mm inside a collider", 1e3 * max_penetration);
    warnings.emplace_back(text);
  }
  if (controller && !controller->complaint().empty()) warnings.push_back(controller->complaint());
  if (!failure.empty()) {
    warnings.push_back(failure);
  } else if (!report.converged && report.residual > kNotableResidual) {
    std::snprintf(text, sizeof text, "the step is inaccurate: RMS unbalanced acceleration %.3g m/s^2; %s",
                  report.residual,
                  settings.chosen.empty() ? "a smaller step.dt or more step.newton_iterations mend it"
                                          : "a smaller step.accuracy mends it");
    warnings.emplace_back(text);
  }
  return warnings;
}

void World::Parts::add_elastic_energies(std::vector<BodyReport>* reports) {
  if (body_of_energy.empty()) {
    for (const auto& e : model->energies) body_of_energy.push_back(body_of(*model, *e));
  }
  for (size_t k = 0; k < body_of_energy.size(); ++k) {
    if (body_of_energy[k] < 0) continue;
    (*reports)[static_cast<size_t>(body_of_energy[k])].elastic_energy += model->energies[k]->value(state);
  }
}

Snapshot World::snapshot(SnapshotDetail detail) const {
  Parts& w = *parts_;
  Snapshot s;
  s.time = w.state.time;
  s.step = w.step_count;
  s.model = w.model;
  s.x = w.state.x;
  s.v = w.state.v;
  copy_rod_frames(*w.model, w.state, &s);
  s.bodies.resize(w.model->bodies.size());
  count_contacts(*w.model, w.dynamics.contacts, &s);
  s.grasps = w.grasps.reports();
  s.colliders = w.colliders.colliders();
  s.report = w.report;
  s.integrator = w.integrator->name();
  s.dt = w.settings.dt;
  s.substeps = w.substeps;
  s.repeated = w.repeated;
  s.energy_created = w.book.created();
  s.max_penetration = w.max_penetration;
  if (detail == SnapshotDetail::kMotion) return s;

  for (size_t b = 0; b < s.bodies.size(); ++b) add_report(*w.model, w.model->bodies[b], w.state, &s.bodies[b]);
  w.add_elastic_energies(&s.bodies);
  s.warnings = w.warnings();
  warn_of_strain(*w.model, s.bodies, &s.warnings);
  warn_of_inversion(*w.model, w.state.x, s.bodies, &s.warnings);

  const CostWindow& cost = w.last_cost.steps > 0 ? w.last_cost : w.cost;
  if (cost.steps == 0) return s;
  const double per_second = 1.0 / (cost.steps * w.settings.dt);
  s.cost.push_back({"forces and assembly", cost.assembly * per_second});
  if (w.dynamics.pattern != nullptr) s.cost.push_back({"linear solver", cost.solve * per_second});
  s.cost.push_back({"integrator", std::max(0.0, cost.integrate - cost.assembly - cost.solve) * per_second});
  if (w.limiter) s.cost.push_back({"strain limits", cost.limits * per_second});
  if (w.contacts) s.cost.push_back({"contact", cost.contact * per_second});
  if (w.meetings) s.cost.push_back({"contact of bodies", cost.meetings * per_second});
  if (!w.grasps.empty()) s.cost.push_back({"grasps", cost.grasps * per_second});
  return s;
}

namespace {

int body_of(const Model& model, int node) {
  int body = 0;
  while (node >=
         model.bodies[static_cast<size_t>(body)].first_node + model.bodies[static_cast<size_t>(body)].node_count)
    ++body;
  return body;
}

}  // namespace

std::vector<ContactReport> World::contact_reports() const {
  const Parts& w = *parts_;
  std::vector<ContactReport> reports;
  for (const ContactConstraint& c : w.dynamics.contacts) {
    if (c.force.isZero(0.0)) continue;
    ContactReport r;
    r.body = body_of(*w.model, c.node[0]);
    const double radius = w.model->bodies[static_cast<size_t>(r.body)].contact_radius;
    const Vec3 p = contact_position(c, w.state.x);
    r.collider = c.collider;
    r.normal = c.normal;
    r.force = c.force;
    r.distance = c.normal.dot(p) - c.offset;
    r.point = p - (r.distance + radius) * c.normal;
    if (c.collider < 0) {
      // The first body's surface; the second is behind it.
      r.point = -(r.distance + radius) * c.normal;
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        if (c.weight[k] > 0.0) r.point += c.weight[k] * w.state.x.col(c.node[k]);
      }
      r.other = body_of(*w.model, c.node[static_cast<size_t>(c.count) - 1]);
    }
    reports.push_back(r);
  }
  return reports;
}

std::vector<GraspReport> World::grasp_reports() const {
  return parts_->grasps.reports();
}

std::vector<BillItem> World::bill() const {
  const Parts& w = *parts_;
  const CostWindow& cost = w.last_cost.steps > 0 ? w.last_cost : w.cost;
  const double total = cost.total() > 0.0 ? cost.total() : 1.0;

  std::vector<BillItem> bill;
  // Terms of one name, of several bodies, are one line.
  std::vector<double> seconds;
  std::vector<int> counts;
  double sum = 0.0;
  Nodes work = Nodes::Zero(3, w.model->node_count());
  for (const Energy* e : w.dynamics.energies) {
    const std::string name = e->name();
    auto line = std::find_if(bill.begin(), bill.end(), [&](const BillItem& item) { return item.part == name; });
    if (line == bill.end()) {
      line = bill.insert(bill.end(), BillItem{name, "", 0.0});
      seconds.push_back(0.0);
      counts.push_back(0);
    }
    const auto k = static_cast<size_t>(line - bill.begin());
    const double spent = force_seconds(*e, w.state, &work);
    seconds[k] += spent;
    counts[k] += e->element_count();
    sum += spent;
  }
  for (size_t k = 0; k < bill.size(); ++k) {
    bill[k].detail = counted(bill[k].part, counts[k]);
    bill[k].share = sum > 0.0 ? cost.assembly / total * seconds[k] / sum : 0.0;
  }
  if (w.dynamics.pattern != nullptr) {
    bill.push_back({"linear solver",
                    solver_name(w.settings.solver, *w.integrator, w.dynamics) + ", " +
                        std::to_string(w.pattern.block_count()) + " blocks of 3 x 3",
                    cost.solve / total});
  }
  const int angles = w.model->angle_count;
  bill.push_back({w.integrator->name(),
                  std::to_string(w.model->point_count()) + " nodes" +
                      (angles > 0 ? ", " + std::to_string(angles) + " angles" : "") + threads_text(w.workers.get()),
                  std::max(0.0, cost.integrate - cost.assembly - cost.solve) / total});
  if (w.limiter) bill.push_back({"strain limits", std::to_string(w.limiter->count()) + " limits", cost.limits / total});
  if (w.contacts)
    bill.push_back({"contact",
                    std::to_string(w.contacts->point_count()) + " points, " +
                        std::to_string(w.contacts->shape_count()) + " shapes",
                    cost.contact / total});
  if (w.meetings) {
    bill.push_back({"contact of bodies", std::to_string(w.meetings->piece_count()) + " pieces", cost.meetings / total});
  }
  if (!w.grasps.empty())
    bill.push_back({"grasps", std::to_string(w.grasps.held_count()) + " nodes", cost.grasps / total});
  return bill;
}

}  // namespace deformable_sim
