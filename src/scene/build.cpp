#include "deformable_sim/scene/build.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/grasp/selection.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/scene/mesh_file.h"
#include "features.h"

namespace deformable_sim {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Soft, distinguishable colours for bodies that name none, by their order.
constexpr std::array<std::array<double, 3>, 6> kPalette{{{{0.36, 0.61, 0.84}},
                                                         {{0.93, 0.60, 0.33}},
                                                         {{0.50, 0.73, 0.42}},
                                                         {{0.80, 0.45, 0.55}},
                                                         {{0.62, 0.53, 0.80}},
                                                         {{0.85, 0.78, 0.45}}}};

[[noreturn]] void refuse_at(const Location& where, const std::string& what, Code code) {
  throw InputError(where.file + (where.line > 0 ? ":" + std::to_string(where.line) : "") + ": " + what, code);
}

/// What all bodies together add to the model, in world node indices.
struct Parts {
  std::vector<SpringLink> stretch, shear, bend;
  std::vector<std::array<int, 3>> triangles;
  struct Line {
    std::vector<std::array<int, 2>> segments;
    double diameter;
  };
  std::vector<Line> lines;
  std::vector<Nodes> positions;
  std::vector<Eigen::VectorXd> masses;
  int node_count = 0;
};

void append_links(const std::vector<SpringLink>& links, int first_node, std::vector<SpringLink>* out) {
  for (SpringLink link : links) {
    link.a += first_node;
    link.b += first_node;
    out->push_back(link);
  }
}

/// Springs, strain edges, masses and positions: what cloth and rope have in common.
void add_network(const SpringNetwork& network, const Nodes& rest, const Pose& world_from_body,
                 const Eigen::VectorXd& mass, Body* body, Parts* parts) {
  append_links(network.stretch, body->first_node, &parts->stretch);
  append_links(network.shear, body->first_node, &parts->shear);
  append_links(network.bend, body->first_node, &parts->bend);
  for (const SpringLink& link : network.stretch) {
    body->strain_edges.push_back({{link.a + body->first_node, link.b + body->first_node}, link.rest_length});
  }
  body->node_count = static_cast<int>(rest.cols());
  parts->positions.push_back((world_from_body.linear() * rest).colwise() + Vec3(world_from_body.translation()));
  parts->masses.push_back(mass);
  parts->node_count += body->node_count;
}

void add_cloth(const BodySpec& spec, Body* body, Parts* parts) {
  const ClothMaterialSpec& material = spec.cloth_material;
  const TriangleMesh mesh = spec.mesh.empty() ? make_grid(spec.size[0], spec.size[1], spec.cells[0], spec.cells[1])
                                              : load_mesh(spec.mesh, spec.mesh_scale);
  SheetStiffness stiffness;
  stiffness.membrane = material.youngs_modulus * material.thickness;
  stiffness.poissons_ratio = material.poissons_ratio;
  stiffness.stretch = material.stretch_stiffness;
  stiffness.shear = material.shear_stiffness;
  stiffness.bend = material.bend_stiffness;
  stiffness.damping_time = material.damping;
  for (const std::array<int, 3>& t : mesh.triangles) {
    parts->triangles.push_back({t[0] + body->first_node, t[1] + body->first_node, t[2] + body->first_node});
  }
  add_network(sheet_network(mesh, stiffness), mesh.rest, spec.pose.pose(), sheet_masses(mesh, material.areal_density),
              body, parts);
  body->contact_at_faces = spec.contact_at_faces;
  body->contact_radius = spec.contact_radius.value_or(std::max(0.5 * material.thickness, kMinContactRadius));
  body->features = sheet_features(mesh);
  body->surface = std::make_shared<TriangleMesh>(mesh);
}

void add_rope(const BodySpec& spec, Body* body, Parts* parts) {
  const RopeMaterialSpec& material = spec.rope_material;
  const Polyline line = spec.closed ? make_ring(spec.length, spec.segments) : make_line(spec.length, spec.segments);
  LineStiffness stiffness;
  stiffness.axial = material.youngs_modulus * 0.25 * kPi * material.diameter * material.diameter;
  stiffness.stretch = material.stretch_stiffness;
  stiffness.bend = material.bend_stiffness;
  stiffness.damping_time = material.damping;
  Parts::Line segments{{}, material.diameter};
  for (int s = 0; s < line.segment_count(); ++s) {
    const std::array<int, 2> ends = line.segment(s);
    segments.segments.push_back({ends[0] + body->first_node, ends[1] + body->first_node});
  }
  parts->lines.push_back(std::move(segments));
  add_network(line_network(line, stiffness), line.rest, spec.pose.pose(), line_masses(line, material.linear_density),
              body, parts);
  // A chord between two nodes would cut a round collider deeper than a rope is thick.
  body->contact_at_faces = true;
  body->contact_radius = spec.contact_radius.value_or(std::max(0.5 * material.diameter, kMinContactRadius));
  body->draw_radius = 0.5 * material.diameter;
  body->features = line_features(line);
  body->line = std::make_shared<Polyline>(line);
}

void add_air(const AirSpec& spec, const Parts& parts, Model* model) {
  if (spec.damping > 0.0) model->energies.push_back(make_mass_damping(model->mass, spec.damping));
  if (spec.drag_coefficient == 0.0 || spec.density == 0.0) return;
  const Air air{spec.density, spec.drag_coefficient, spec.wind, spec.gust_amplitude, spec.gust_frequency};
  if (!parts.triangles.empty()) model->energies.push_back(make_sheet_drag(parts.triangles, air));
  for (const Parts::Line& line : parts.lines) {
    model->energies.push_back(make_line_drag(line.segments, line.diameter, air));
  }
}

void gather_nodes(const Parts& parts, Model* model) {
  model->mass.resize(parts.node_count);
  model->initial.x.resize(3, parts.node_count);
  model->initial.v = Nodes::Zero(3, parts.node_count);
  for (size_t b = 0; b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    model->mass.segment(body.first_node, body.node_count) = parts.masses[b];
    model->initial.x.middleCols(body.first_node, body.node_count) = parts.positions[b];
  }
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
    const char* kind = body.kind == BodyKind::kRope ? "].rope.pins" : "].cloth.pins";
    for (const std::string& feature : body.pins) {
      grasps.push_back({body.pins_where, "bodies[" + std::to_string(b) + kind, pin(body.name, feature)});
    }
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

}  // namespace

std::shared_ptr<const Model> build_model(const SceneSpec& spec) {
  auto model = std::make_shared<Model>();
  Parts parts;
  for (size_t b = 0; b < spec.bodies.size(); ++b) {
    const BodySpec& from = spec.bodies[b];
    Body body;
    body.name = from.name;
    body.kind = from.kind;
    body.first_node = parts.node_count;
    body.friction = from.friction;
    const std::array<double, 3> color = from.color.value_or(kPalette[b % kPalette.size()]);
    body.color = {color[0], color[1], color[2], 1.0};
    try {
      (from.kind == BodyKind::kRope ? add_rope : add_cloth)(from, &body, &parts);
    } catch (const InputError& error) {
      const bool mesh = !from.mesh.empty();
      const std::string path = "bodies[" + std::to_string(b) + "]" + (mesh ? ".cloth.mesh" : "");
      refuse_at(mesh ? from.mesh_where : from.where, path + ": " + error.what(), error.code());
    }
    if (parts.node_count > kMaxNodes) {
      refuse_at(from.where,
                "bodies: " + std::to_string(parts.node_count) + " nodes so far; at most " + std::to_string(kMaxNodes) +
                    " in a scene",
                Code::kOutOfRange);
    }
    model->bodies.push_back(std::move(body));
  }
  gather_nodes(parts, model.get());
  model->gravity = spec.gravity;
  if (!parts.stretch.empty()) model->energies.push_back(make_springs("stretch springs", parts.stretch, 0));
  if (!parts.shear.empty()) model->energies.push_back(make_springs("shear springs", parts.shear, 0));
  if (!parts.bend.empty()) model->energies.push_back(make_springs("bend springs", parts.bend, 0));
  if (spec.gravity.squaredNorm() > 0.0) model->energies.push_back(make_gravity(model->mass, spec.gravity));
  add_air(spec.air, parts, model.get());
  return model;
}

std::unique_ptr<World> build_world(const SceneSpec& spec) {
  std::shared_ptr<const Model> model = build_model(spec);
  WorldSettings settings;
  settings.dt = spec.step.dt;
  settings.integrator = spec.step.integrator;
  settings.solver = spec.step.solver;
  settings.grasp_max_speed = spec.grasp_max_speed;
  std::vector<Collider> colliders;
  for (const ColliderSpec& collider : spec.colliders) colliders.push_back(collider.collider);
  const std::vector<PlacedGrasp> placed = all_grasps(spec);
  check_grasps(placed, *model);
  std::vector<GraspRequest> grasps;
  for (const PlacedGrasp& grasp : placed) grasps.push_back(grasp.request);
  try {
    return std::make_unique<World>(std::move(model), settings, std::move(colliders), std::move(grasps));
  } catch (const InputError& error) {
    throw InputError(spec.file + (spec.file.empty() ? "" : ": ") + error.what(), error.code());
  }
}

}  // namespace deformable_sim
