#include "deformable_sim/scene/build.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "build_parts.h"
#include "deformable_sim/core/contact/body_contacts.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/grasp/selection.h"
#include "deformable_sim/scene/solver_choice.h"

namespace deformable_sim {
namespace {

/// Soft, distinguishable colours for bodies that name none, by their order.
constexpr std::array<std::array<double, 3>, 6> kPalette{{{{0.36, 0.61, 0.84}},
                                                         {{0.93, 0.60, 0.33}},
                                                         {{0.50, 0.73, 0.42}},
                                                         {{0.80, 0.45, 0.55}},
                                                         {{0.62, 0.53, 0.80}},
                                                         {{0.85, 0.78, 0.45}}}};

// Segments that a wave of tension passes in a step. Beyond, what Newton's method leaves after four steps, each solved
// to a tenth, is no motion of the rope: its end is off by a good part of its length within a second. Real ropes, named
// and not made up, are held to a stricter one: to a hundredth.
constexpr double kStiffRope = 200.0, kStiffRealRope = 20.0;
constexpr int kRopeIterations = 20;    // at most: one or two are taken, more where a contact closes
constexpr int kStiffIterations = 100;  // at most: ten to thirty are taken, more by long chains without bending

[[noreturn]] void refuse_at(const Location& where, const std::string& what, Code code) {
  throw InputError(where.file + (where.line > 0 ? ":" + std::to_string(where.line) : "") + ": " + what, code);
}

void add_air(const AirSpec& spec, const Parts& parts, Model* model) {
  if (spec.damping > 0.0) model->energies.push_back(make_mass_damping(model->mass, spec.damping));
  if (spec.drag_coefficient == 0.0 || spec.density == 0.0) return;
  const Air air{spec.density, spec.drag_coefficient, spec.wind, spec.gust_amplitude, spec.gust_frequency};
  if (!parts.sheet_triangles.empty()) model->energies.push_back(make_sheet_drag(parts.sheet_triangles, air));
  if (!parts.solid_triangles.empty()) {
    // A sheet shows the air one face of an element where a solid shows two, in front and behind.
    Air half = air;
    half.drag_coefficient *= 0.5;
    model->energies.push_back(make_sheet_drag(parts.solid_triangles, half));
  }
  for (const Parts::Line& line : parts.lines) {
    model->energies.push_back(make_line_drag(line.segments, line.diameter, air));
  }
}

void add_forces(const SceneSpec& spec, const std::shared_ptr<ForcePlugin>& plugins, Model* model) {
  if (plugins && !spec.forces.empty()) model->plugins = plugins;
  for (size_t k = 0; k < spec.forces.size(); ++k) {
    const ForceSpec& force = spec.forces[k];
    const std::string path = "forces[" + std::to_string(k) + "]";
    try {
      if (!plugins) throw InputError("only the node loads plugins", Code::kUnavailable);
      std::unique_ptr<Energy> term = plugins->make(force.request, *model);
      if (!term) throw InputError("plugin '" + force.request.plugin + "' has made no force", Code::kInternal);
      model->energies.push_back(std::move(term));
    } catch (const InputError& error) {
      refuse_at(force.where, path + ": " + error.what(), error.code());
    } catch (const std::exception& error) {
      refuse_at(force.where, path + ": plugin '" + force.request.plugin + "': " + error.what(), Code::kInternal);
    }
  }
}

/// One kind of springs of all bodies, a term for each body.
void add_springs(const char* name, std::vector<SpringLink> SpringNetwork::*links, Parts* parts, Model* model) {
  for (size_t k = 0; k < parts->springs.size(); ++k) {
    if ((parts->springs[k].*links).empty()) continue;
    model->energies.push_back(make_springs(name, parts->springs[k].*links, 0));
    for (Parts::Grid& grid : parts->grids) {
      if (grid.network == k) grid.replaces.push_back(model->energies.back().get());
    }
  }
}

void gather_nodes(const Parts& parts, Model* model) {
  for (const Parts::Rod& rod : parts.rods) model->angle_count += rod.line.segment_count();
  const int count = parts.node_count + model->angle_count;
  model->mass.resize(count);
  model->initial.x = Nodes::Zero(3, count);
  model->initial.v = Nodes::Zero(3, count);
  for (size_t b = 0; b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    model->mass.segment(body.first_node, body.node_count) = parts.masses[b];
    model->initial.x.middleCols(body.first_node, body.node_count) = parts.positions[b];
  }
}

/// Terms, angles and frames of all rods, behind the points of all bodies.
void add_rods(const SceneSpec& spec, const Parts& parts, Model* model) {
  if (model->angle_count == 0) return;
  State& state = model->initial;
  state.directors.resize(3, model->angle_count);
  state.tangents.resize(3, model->angle_count);
  state.reference_twists.resize(model->angle_count);
  int first_segment = 0;
  for (const Parts::Rod& rod : parts.rods) {
    Body& body = model->bodies[rod.body];
    const int first_angle = parts.node_count + first_segment, count = rod.line.segment_count();
    RodTerms terms;
    try {
      terms = make_rod(rod.line, rod.section, rod.rest, body.first_node, first_angle, first_segment);
    } catch (const InputError& error) {
      refuse_at(spec.bodies[rod.body].where, "bodies[" + std::to_string(rod.body) + "].rope: " + error.what(),
                error.code());
    }
    for (auto& term : terms.energies) model->energies.push_back(std::move(term));
    state.directors.middleCols(first_segment, count) = terms.directors;
    state.tangents.middleCols(first_segment, count) = terms.tangents;
    state.reference_twists.segment(first_segment, count) = terms.reference_twists;
    for (int k = 0; k < count; ++k) {
      const auto [a, b] = rod.line.segment(k);
      const double turned = k * rod.initial_twist * (rod.line.rest.col(b) - rod.line.rest.col(a)).norm();
      state.x(0, first_angle + k) = rod.section.radius_of_gyration * (terms.angles[k] + turned);
    }
    model->mass.segment(first_angle, count) = terms.angle_masses;
    body.first_segment = first_segment;
    first_segment += count;
  }
}

/// Consistent masses where bodies have them, lumped ones elsewhere; nothing when all are lumped.
void fill_mass_matrix(const Parts& parts, Model* model) {
  if (parts.mass_entries.empty()) return;
  std::vector<Eigen::Triplet<double>> entries = parts.mass_entries;
  std::vector<char> consistent(static_cast<size_t>(model->node_count()), 0);
  for (const Eigen::Triplet<double>& entry : entries) consistent[static_cast<size_t>(entry.row())] = 1;
  for (int i = 0; i < model->node_count(); ++i) {
    if (!consistent[static_cast<size_t>(i)]) entries.emplace_back(i, i, model->mass[i]);
  }
  model->mass_matrix.resize(model->node_count(), model->node_count());
  model->mass_matrix.setFromTriplets(entries.begin(), entries.end());
}

/// Masses that have weight: those of points, not of angles.
Eigen::VectorXd weights_of(const Model& model) {
  Eigen::VectorXd mass = model.mass;
  mass.tail(model.angle_count).setZero();
  return mass;
}

void add_body(const BodySpec& spec, Body* body, Parts* parts) {
  switch (spec.kind) {
    case BodyKind::kCloth:
      return add_cloth(spec, body, parts);
    case BodyKind::kRope:
      return add_rope(spec, body, parts);
    case BodyKind::kSoft:
      return add_soft(spec, body, parts);
  }
}

const char* kind_name(BodyKind kind) {
  return kind == BodyKind::kRope ? "rope" : kind == BodyKind::kSoft ? "soft" : "cloth";
}

GraspRequest pin(const std::string& body, const std::string& feature) {
  GraspRequest request;
  request.name = "pin_" + body + "_" + feature;
  request.body = body;
  request.selection.method = SelectionMethod::kFeature;
  request.selection.feature = feature;
  return request;
}

struct PlacedGrasp {
  Location where;
  std::string path;
  GraspRequest request;
};

/// Pins first, as grasps; then the scene's own.
std::vector<PlacedGrasp> all_grasps(const SceneSpec& spec) {
  std::vector<PlacedGrasp> grasps;
  for (size_t b = 0; b < spec.bodies.size(); ++b) {
    const BodySpec& body = spec.bodies[b];
    const std::string path = "bodies[" + std::to_string(b) + "]." + kind_name(body.kind) + ".pins";
    for (const std::string& feature : body.pins) grasps.push_back({body.pins_where, path, pin(body.name, feature)});
  }
  for (size_t k = 0; k < spec.grasps.size(); ++k) {
    grasps.push_back({spec.grasps[k].where, "grasps[" + std::to_string(k) + "].select", spec.grasps[k].request});
  }
  return grasps;
}

/// Finds the nodes of every grasp as the world will, to name the line when there are none or another grasp has them.
void check_grasps(const std::vector<PlacedGrasp>& grasps, const Model& model) {
  std::map<int, std::string> taken;
  for (const PlacedGrasp& grasp : grasps) {
    const std::string who = grasp.path + ": ";
    const int index = model.find_body(grasp.request.body);
    if (index < 0) refuse_at(grasp.where, who + "no body '" + grasp.request.body + "'", Code::kNotFound);
    const Body& body = model.bodies[static_cast<size_t>(index)];
    std::vector<int> nodes;
    try {
      nodes = select_nodes(body, model.initial.x, grasp.request.selection);
      if (grasp.request.stiffness == 0.0 && !grasp.request.points_only) nodes = clamped_nodes(body, nodes);
    } catch (const InputError& error) {
      refuse_at(grasp.where, who + error.what(), error.code());
    }
    for (const int node : nodes) {
      const auto holder = taken.find(body.first_node + node);
      if (holder != taken.end()) {
        refuse_at(grasp.where,
                  who + "node " + std::to_string(node) + " of '" + body.name + "' is already held by '" +
                      holder->second + "'",
                  Code::kUnavailable);
      }
      // A soft grasp pulls; it does not keep others from taking the node.
      if (grasp.request.stiffness == 0.0) taken[body.first_node + node] = grasp.request.name;
    }
  }
}

bool is_stiff_rope(const BodySpec& body, double dt) {
  if (body.kind != BodyKind::kRope) return false;
  const double most = body.rope_material.name.empty() ? kStiffRope : kStiffRealRope;
  return segments_per_second(body) * dt > most;
}

/// What the scene says, and what its ropes need where it says nothing. Beside other bodies a rope is factorised
/// whatever its stiffness: in one conjugate gradient solve with them it would set the number of iterations of all.
/// Ropes alone are always: that is the cheaper way, and Newton's method then takes as many steps as it needs, mostly
/// one or two.
SolverSettings solver_settings(const SceneSpec& spec) {
  SolverSettings settings = spec.step.solver;
  bool stiff = false, rope = false, ropes_alone = !spec.bodies.empty();
  for (const BodySpec& body : spec.bodies) {
    stiff = stiff || is_stiff_rope(body, spec.step.dt);
    rope = rope || body.kind == BodyKind::kRope;
    ropes_alone = ropes_alone && body.kind == BodyKind::kRope;
  }
  const bool banded = ropes_alone || stiff || (rope && spec.bodies.size() > 1);
  if (banded && !spec.step.solver_given) settings.linear = SolverSettings::Linear::kBanded;
  if (ropes_alone && !spec.step.solver_given && !spec.step.jacobian_given) settings.jacobian = Jacobian::kLagged;
  if (!spec.step.iterations_given) {
    if (ropes_alone) settings.newton_iterations = kRopeIterations;
    if (stiff) settings.newton_iterations = kStiffIterations;
  }
  return settings;
}

bool can_run(const Model& model, const std::string& integrator) {
  try {
    check_scheme(*make_integrator(integrator, {}), model);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

/// What a World refuses: at the later of two bodies that cross, else with the file alone.
[[noreturn]] void refuse_world(const SceneSpec& spec, const Model& model, const InputError& error) {
  const std::string crossing = BodyContacts(&model).find_crossing(model.initial.x);
  for (size_t b = spec.bodies.size(); b-- > 0 && !crossing.empty();) {
    const BodySpec& body = spec.bodies[b];
    if (crossing.find("'" + body.name + "'") == std::string::npos || body.touches == BodyContact::kNone) continue;
    refuse_at(body.where, "bodies[" + std::to_string(b) + "]: " + error.what(), error.code());
  }
  throw InputError(spec.file + (spec.file.empty() ? "" : ": ") + error.what(), error.code());
}

}  // namespace

std::vector<GraspRequest> grasps_of(const SceneSpec& spec) {
  std::vector<GraspRequest> grasps;
  for (const PlacedGrasp& grasp : all_grasps(spec)) grasps.push_back(grasp.request);
  return grasps;
}

SolverChoice choose_for(const SceneSpec& spec, const Model& model, const SceneFeatures& features,
                        const SolverTable& table) {
  SolverWish wish{spec.step.error, spec.step.budget, std::nullopt};
  if (spec.step.dt_given) wish.dt = spec.step.dt;
  return choose_solver(features, wish, table,
                       [&model](const std::string& integrator) { return can_run(model, integrator); });
}

WorldSettings settings_for(const SceneSpec& spec, const SolverChoice* choice) {
  WorldSettings settings;
  settings.dt = spec.step.dt;
  settings.integrator = spec.step.integrator;
  settings.solver = solver_settings(spec);
  settings.control = {spec.step.control, spec.step.error, spec.step.budget, spec.step.floor};
  settings.grasp_max_speed = spec.grasp_max_speed;
  if (choice == nullptr) return settings;
  const SolverConfiguration& chosen = choice->configuration;
  settings.dt = chosen.dt;
  settings.parts = choice->parts;
  settings.chosen = choice->why;
  if (!choice->measured()) return settings;
  settings.integrator = chosen.integrator;
  settings.chosen = chosen.text() + ": " + choice->why;
  const bool ropes = std::all_of(spec.bodies.begin(), spec.bodies.end(),
                                 [](const BodySpec& body) { return body.kind == BodyKind::kRope; });
  const int ample = settings.solver.newton_iterations;
  settings.solver = settings_of(chosen, settings.solver, ropes);
  // As many as stiff ropes may need: the tolerance ends them, of measured ones too.
  if (ropes) settings.solver.newton_iterations = ample;
  return settings;
}

std::shared_ptr<const Model> build_model(const SceneSpec& spec, std::shared_ptr<ForcePlugin> plugins) {
  auto model = std::make_shared<Model>();
  Parts parts;
  int skin_vertices = 0;
  for (size_t b = 0; b < spec.bodies.size(); ++b) {
    const BodySpec& from = spec.bodies[b];
    Body body;
    body.name = from.name;
    body.kind = from.kind;
    body.first_node = parts.node_count;
    body.friction = from.friction;
    body.touches = from.touches;
    const std::array<double, 3> color = from.color.value_or(kPalette[b % kPalette.size()]);
    body.color = {color[0], color[1], color[2], 1.0};
    try {
      add_body(from, &body, &parts);
      add_visual(from.visual, &body);
      add_look(from, &body);
    } catch (const PlacedError&) {
      throw;
    } catch (const InputError& error) {
      const bool mesh = !from.mesh.empty();
      const std::string path =
          "bodies[" + std::to_string(b) + "]" + (mesh ? std::string(".") + kind_name(from.kind) + ".mesh" : "");
      refuse_at(mesh ? from.mesh_where : from.where, path + ": " + error.what(), error.code());
    }
    if (parts.node_count > kMaxNodes) {
      refuse_at(from.where,
                "bodies: " + std::to_string(parts.node_count) + " nodes so far; at most " + std::to_string(kMaxNodes) +
                    " in a scene",
                Code::kOutOfRange);
    }
    if (body.skin) skin_vertices += body.skin->vertex_count();
    if (skin_vertices > kMaxSkinVertices) {
      refuse_at(from.where,
                "bodies: " + std::to_string(skin_vertices) + " vertices of visual surfaces so far; at most " +
                    std::to_string(kMaxSkinVertices) + " in a scene",
                Code::kOutOfRange);
    }
    model->bodies.push_back(std::move(body));
  }
  gather_nodes(parts, model.get());
  model->gravity = spec.gravity;
  model->notes = std::move(parts.notes);
  model->strain_limits = std::move(parts.strain_limits);
  add_springs("stretch springs", &SpringNetwork::stretch, &parts, model.get());
  add_springs("shear springs", &SpringNetwork::shear, &parts, model.get());
  add_springs("bend springs", &SpringNetwork::bend, &parts, model.get());
  for (auto& term : parts.terms) model->energies.push_back(std::move(term));
  for (Parts::Grid& grid : parts.grids) {
    grid.sheet.replaces = std::move(grid.replaces);
    model->grids.push_back(std::move(grid.sheet));
  }
  add_rods(spec, parts, model.get());
  fill_mass_matrix(parts, model.get());
  if (spec.gravity.squaredNorm() > 0.0) model->energies.push_back(make_gravity(weights_of(*model), spec.gravity));
  add_air(spec.air, parts, model.get());
  add_forces(spec, plugins, model.get());
  return model;
}

std::unique_ptr<World> build_world(const SceneSpec& asked, int threads, std::shared_ptr<ForcePlugin> plugins,
                                   std::optional<double> running_dt) {
  SceneSpec spec = asked;
  if (running_dt) {
    spec.step.dt = *running_dt;
    spec.step.dt_given = true;
  }
  std::shared_ptr<const Model> model = build_model(spec, std::move(plugins));
  SolverChoice choice;
  const bool open = spec.step.mode == SolverMode::kAuto;
  if (open) choice = choose_for(spec, *model, features_of(spec, *model), read_solver_table(solver_table_file()));
  WorldSettings settings = settings_for(spec, open ? &choice : nullptr);
  settings.threads = threads;
  settings.may_start_crossed = running_dt.has_value();
  std::vector<Collider> colliders;
  for (const ColliderSpec& collider : spec.colliders) colliders.push_back(collider.collider);
  check_grasps(all_grasps(spec), *model);
  try {
    return std::make_unique<World>(model, settings, std::move(colliders), grasps_of(spec));
  } catch (const InputError& error) {
    refuse_world(spec, *model, error);
  }
}

}  // namespace deformable_sim
