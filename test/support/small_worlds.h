// Small models for tests: loose mass points and a spring sheet.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/world.h"

namespace deformable_sim::test {

/// Unconnected mass points of one body "points": a rope without springs.
inline std::shared_ptr<Model> points_model(const Nodes& x, double mass, const Vec3& gravity) {
  auto model = std::make_shared<Model>();
  Body body;
  body.name = "points";
  body.kind = BodyKind::kRope;
  body.node_count = static_cast<int>(x.cols());
  model->bodies.push_back(body);
  model->mass = Eigen::VectorXd::Constant(x.cols(), mass);
  model->gravity = gravity;
  if (!gravity.isZero()) model->energies.push_back(make_gravity(model->mass, gravity));
  model->initial.x = x;
  model->initial.v = Nodes::Zero(3, x.cols());
  return model;
}

struct Sheet {
  double size_x = 0.5, size_y = 0.5;  // m
  int cells_x = 20, cells_y = 20;
  double areal_density = 0.15;    // kg/m^2
  double membrane = 250.0;        // N/m
  double bend = 0.05;             // N/m
  double damping_time = 0.002;    // s
  double mass_damping = 0.0;      // 1/s
  double contact_radius = 0.001;  // m
  bool contact_at_faces = false;
  double friction = 0.5;
  Vec3 position = Vec3::Zero();
  Vec3 gravity{0, 0, -9.81};
};

/// One spring sheet "towel", lying in the x-y plane around `position`.
inline std::shared_ptr<Model> sheet_model(const Sheet& sheet) {
  auto model = std::make_shared<Model>();
  auto mesh = std::make_shared<TriangleMesh>(make_grid(sheet.size_x, sheet.size_y, sheet.cells_x, sheet.cells_y));
  Body body;
  body.name = "towel";
  body.node_count = static_cast<int>(mesh->rest.cols());
  body.surface = mesh;
  body.contact_radius = sheet.contact_radius;
  body.contact_at_faces = sheet.contact_at_faces;
  body.friction = sheet.friction;
  const int row = sheet.cells_x + 1, last = body.node_count - 1;
  body.features = {{"corner_0", {0}}, {"corner_1", {row - 1}}, {"corner_2", {last}}, {"corner_3", {last - row + 1}}};

  SheetStiffness stiffness;
  stiffness.membrane = sheet.membrane;
  stiffness.bend = sheet.bend;
  stiffness.damping_time = sheet.damping_time;
  const SpringNetwork network = sheet_network(*mesh, stiffness);
  for (const SpringLink& l : network.stretch) body.strain_edges.push_back({{{l.a, l.b}}, l.rest_length});
  model->mass = sheet_masses(*mesh, sheet.areal_density);
  model->gravity = sheet.gravity;
  model->energies.push_back(make_springs("stretch springs", network.stretch, 0));
  if (!network.shear.empty()) model->energies.push_back(make_springs("shear springs", network.shear, 0));
  if (!network.bend.empty()) model->energies.push_back(make_springs("bend springs", network.bend, 0));
  if (sheet.mass_damping > 0.0) model->energies.push_back(make_mass_damping(model->mass, sheet.mass_damping));
  if (!sheet.gravity.isZero()) model->energies.push_back(make_gravity(model->mass, sheet.gravity));
  model->initial.x = mesh->rest.colwise() + sheet.position;
  model->initial.v = Nodes::Zero(3, mesh->rest.cols());
  model->bodies.push_back(std::move(body));
  return model;
}

inline Pose at(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(x, y, z);
  return pose;
}

inline Pose at(double x, double y, double z, double angle, const Vec3& axis) {
  Pose pose = at(x, y, z);
  pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  return pose;
}

inline Collider collider(const std::string& name, Shape::Type type, const Vec3& size, const Pose& pose) {
  Collider c;
  c.name = name;
  Shape shape;
  shape.type = type;
  shape.size = size;
  c.shapes.push_back(shape);
  c.world_from_collider = pose;
  return c;
}

inline GraspRequest grasp_nodes(const std::string& name, const std::string& body, std::vector<int> nodes) {
  GraspRequest request;
  request.name = name;
  request.body = body;
  request.selection.method = SelectionMethod::kNodes;
  request.selection.nodes = std::move(nodes);
  return request;
}

/// Everything a refused command may not change, to the last bit.
inline bool same_state(const State& a, const State& b) {
  return a.time == b.time && a.x == b.x && a.v == b.v;
}

}  // namespace deformable_sim::test
