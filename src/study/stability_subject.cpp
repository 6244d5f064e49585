#include "stability_subject.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/grasp/selection.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim::stability {
namespace {

constexpr double kDrag = 1.0;  // 1/s
constexpr int kLinks = 10;
constexpr double kRopeLength = 1.0, kRopeArea = 1e-4, kRopeDensity = 1000.0;  // m, m^2, kg/m^3

double longest_side(const Model& model) {
  const auto x = model.initial.x.leftCols(model.point_count());
  return (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).maxCoeff();
}

/// Nodes of rigid grasps that stay where they are.
std::vector<int> held_nodes(const SceneSpec& spec, const Model& model) {
  std::vector<int> held;
  for (const GraspRequest& grasp : grasps_of(spec)) {
    if (grasp.stiffness > 0.0) continue;
    const Body& body = model.bodies[static_cast<size_t>(model.find_body(grasp.body))];
    std::vector<int> nodes = select_nodes(body, model.initial.x, grasp.selection);
    if (!grasp.points_only) nodes = clamped_nodes(body, nodes);
    for (const int node : nodes) held.push_back(body.first_node + node);
  }
  std::sort(held.begin(), held.end());
  return held;
}

/// A scheme by itself knows rigid grasps of points, and nothing that touches.
bool has_scheme_alone(const SceneSpec& spec, const Model& model) {
  const bool touch = !spec.colliders.empty() || spec.robot.present || !model.strain_limits.empty() ||
                     std::any_of(spec.bodies.begin(), spec.bodies.end(),
                                 [](const BodySpec& b) { return b.touches != BodyContact::kNone; });
  const bool soft =
      std::any_of(spec.grasps.begin(), spec.grasps.end(), [](const GraspSpec& g) { return g.request.stiffness > 0.0; });
  return !touch && !soft && model.angle_count == 0;
}

Subject built(const std::string& name, SceneSpec spec) {
  Subject subject;
  subject.name = name;
  subject.model = build_model(spec);
  subject.held = held_nodes(spec, *subject.model);
  subject.size = longest_side(*subject.model);
  subject.has_scheme_alone = has_scheme_alone(spec, *subject.model);
  subject.spec = std::move(spec);
  return subject;
}

/// Of the rope's model: what only a scene has, for the choice of a solver and the pin.
SceneSpec rope_spec(const Point& at) {
  SceneSpec spec;
  spec.title = "a chain let go at 45 degrees";
  spec.air.damping = kDrag;
  BodySpec body;
  body.kind = BodyKind::kRope;
  body.name = "rope";
  body.length = kRopeLength;
  body.segments = kLinks;
  body.pins = {"end_0"};
  body.rope_material.linear_density = kRopeDensity * kRopeArea;
  body.rope_material.youngs_modulus = at.stiffness;
  body.rope_material.axial_stiffness = at.stiffness * kRopeArea;
  body.rope_material.damping = at.damping;
  spec.bodies = {body};
  return spec;
}

std::string text_of(double value) {
  std::ostringstream text;
  text.precision(17);
  text << value;
  return text.str();
}

}  // namespace

Subject make_rope(const Point& at) {
  Polyline line = make_line(kRopeLength, kLinks);
  LineStiffness stiffness;
  stiffness.axial = at.stiffness * kRopeArea;
  stiffness.bend = 0.0;
  stiffness.damping_time = at.damping;

  auto model = std::make_shared<Model>();
  model->mass = line_masses(line, kRopeDensity * kRopeArea);
  model->mass[kLinks] = at.mass_ratio * model->mass[kLinks - 1];
  const double slope = std::sqrt(0.5);
  model->initial.x.resize(3, kLinks + 1);
  for (int k = 0; k <= kLinks; ++k) model->initial.x.col(k) = Vec3(slope, 0.0, -slope) * kRopeLength * k / kLinks;
  model->initial.v = Nodes::Zero(3, kLinks + 1);
  model->energies.push_back(make_springs("stretch springs", line_network(line, stiffness).stretch, 0));
  model->energies.push_back(make_gravity(model->mass, model->gravity));
  model->energies.push_back(make_mass_damping(model->mass, kDrag));
  Body body;
  body.name = "rope";
  body.kind = BodyKind::kRope;
  body.node_count = kLinks + 1;
  body.features = {{"end_0", {0}}};
  for (int k = 0; k < kLinks; ++k) body.strain_edges.push_back({{k, k + 1}, kRopeLength / kLinks});
  body.line = std::make_shared<const Polyline>(std::move(line));
  model->bodies.push_back(std::move(body));

  Subject subject;
  subject.name = "rope";
  subject.spec = rope_spec(at);
  subject.size = kRopeLength;
  subject.held = {0};
  subject.model = std::move(model);
  return subject;
}

Subject make_sheet(const Point& at) {
  const std::string scene =
      "title: a membrane held along an edge\n"
      "air: {damping: " +
      text_of(kDrag) +
      "}\n"
      "bodies:\n"
      "  - cloth:\n"
      "      name: sheet\n"
      "      model: membrane\n"
      "      size: [1.2, " +
      text_of(1.2 / at.aspect) +
      "]\n"
      "      cells: [5, 5]\n"
      "      pose: {position: [0.6, 0, 0], rpy: [0, 0.785398163, 0]}\n"
      "      material: {areal_density: 0.2, thickness: 0.001, youngs_modulus: " +
      text_of(at.stiffness) + ", bending_rigidity: 1.0e-5, damping: " + text_of(at.damping) +
      "}\n"
      "      pins: [edge_3]\n";
  return built("sheet", load_scene_text(scene, "sheet"));
}

Subject make_solid(const Point& at) {
  const std::string scene =
      "title: a cantilever\n"
      "air: {damping: " +
      text_of(kDrag) +
      "}\n"
      "bodies:\n"
      "  - soft:\n"
      "      name: solid\n"
      "      box: {size: [0.4, 0.1, 0.1], cells: [4, 1, 1]}\n"
      "      element: tetrahedron\n"
      "      material: {density: 100, poissons_ratio: 0.3, youngs_modulus: " +
      text_of(at.stiffness) + ", damping: " + text_of(at.damping) +
      "}\n"
      "      pins: [face_x0]\n";
  return built("solid", load_scene_text(scene, "solid"));
}

Subject make_scaled(const SceneSpec& scene, const Point& at) {
  SceneSpec spec = scene;
  const auto scale = [&at](auto* value) {
    if (*value) **value *= at.stiffness;
  };
  const auto scale_both = [&at](auto* values) {
    if (*values)
      for (double& value : **values) value *= at.stiffness;
  };
  for (BodySpec& body : spec.bodies) {
    ClothMaterialSpec& cloth = body.cloth_material;
    for (double& modulus : cloth.youngs_modulus) modulus *= at.stiffness;
    for (auto* values : {&cloth.membrane_stiffness, &cloth.bending_rigidity}) scale_both(values);
    for (auto* value : {&cloth.shear_rigidity, &cloth.stretch_stiffness, &cloth.shear_stiffness, &cloth.bend_stiffness})
      scale(value);
    RopeMaterialSpec& rope = body.rope_material;
    rope.youngs_modulus *= at.stiffness;
    scale_both(&rope.bending_rigidity);
    for (auto* value : {&rope.shear_modulus, &rope.axial_stiffness, &rope.twist_rigidity, &rope.stretch_stiffness,
                        &rope.bend_stiffness})
      scale(value);
    body.soft.material.youngs_modulus *= at.stiffness;
  }
  return built("scene", std::move(spec));
}

Subject make_subject(const std::string& name, const Point& at) {
  if (name == "rope") return make_rope(at);
  if (name == "sheet") return make_sheet(at);
  if (name == "solid") return make_solid(at);
  throw InputError("no body '" + name + "'; there is rope, sheet, solid");
}

Plain::Plain(const Subject& subject, bool with_matrix) : state(subject.model->initial) {
  const Model& model = *subject.model;
  dynamics_.mass = &model.mass;
  if (model.mass_matrix.nonZeros() > 0) dynamics_.mass_matrix = &model.mass_matrix;
  for (const auto& energy : model.energies) dynamics_.energies.push_back(energy.get());
  dynamics_.grids = &model.grids;
  dynamics_.kinematics.node = subject.held;
  const auto count = static_cast<Eigen::Index>(subject.held.size());
  dynamics_.kinematics.target.resize(3, count);
  for (Eigen::Index k = 0; k < count; ++k)
    dynamics_.kinematics.target.col(k) = state.x.col(subject.held[static_cast<size_t>(k)]);
  if (!with_matrix) return;
  std::vector<std::array<int, 2>> pairs;
  for (const auto& energy : model.energies) energy->add_pattern(&pairs);
  for (int j = 0; j < model.mass_matrix.outerSize(); ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(model.mass_matrix, j); it; ++it)
      if (it.row() < j) pairs.push_back({static_cast<int>(it.row()), j});
  pattern_ = BlockMatrix(model.node_count(), pairs, model.point_count());
  for (const auto& energy : model.energies) energy->bind(pattern_);
  dynamics_.pattern = &pattern_;
}

StepReport Plain::step(Integrator* integrator, double dt) {
  const StepReport report = integrator->advance(dt, &dynamics_, &state);
  for (const Energy* energy : dynamics_.energies) energy->end_step(&state);
  return report;
}

Fastest fastest_of(const Subject& subject) {
  Plain plain(subject, false);
  return {highest_frequency(plain.dynamics(), plain.state), highest_damping_rate(plain.dynamics(), plain.state)};
}

}  // namespace deformable_sim::stability
