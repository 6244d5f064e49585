// A rod under test: its points, angle columns, terms and frames in a System.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/rod_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/model.h"
#include "support/system.h"

namespace deformable_sim::test {

/// Points first, then one column an angle, as in a Model.
struct RodSystem {
  RodSystem(const Polyline& line, const RodSection& rod_section, const RodRest& rest = {})
      : points(static_cast<int>(line.rest.cols())), segments(line.segment_count()), section(rod_section) {
    RodTerms terms = make_rod(line, section, rest, 0, points, 0);
    Nodes x = Nodes::Zero(3, points + segments);
    x.leftCols(points) = line.rest;
    x.block(0, points, 1, segments) = section.radius_of_gyration * terms.angles.transpose();
    Eigen::VectorXd mass(points + segments);
    mass << line_masses(line, section.linear_density), terms.angle_masses;
    system = std::make_unique<System>(x, mass);
    for (auto& term : terms.energies) system->add(std::move(term));
    system->state.directors = terms.directors;
    system->state.tangents = terms.tangents;
    system->state.reference_twists = terms.reference_twists;
  }

  /// Gravity (m/s^2) on the points.
  RodSystem& add_gravity(const Vec3& g) {
    Eigen::VectorXd weight = system->mass;
    weight.tail(segments).setZero();
    system->add(make_gravity(weight, g));
    return *this;
  }
  /// Holds the first segment: two nodes and the angle, where they are.
  RodSystem& clamp_start() {
    system->hold(0).hold(1).hold(points);
    return *this;
  }

  State& state() { return system->state; }
  double angle(int segment) const { return system->state.x(0, points + segment) / section.radius_of_gyration; }
  void set_angle(int segment, double value) {
    system->state.x(0, points + segment) = value * section.radius_of_gyration;
  }
  /// Brings the frames to the present positions.
  void carry_frames() {
    for (const Energy* term : system->dynamics.energies) term->end_step(&system->state);
  }

  int points, segments;
  RodSection section;
  std::unique_ptr<System> system;
};

/// Nodes at (first + i) * spacing along `direction`.
inline Polyline line_along(const Vec3& direction, double spacing, int nodes, double first = 0.0) {
  Polyline line;
  line.rest.resize(3, nodes);
  for (int i = 0; i < nodes; ++i) line.rest.col(i) = (first + i) * spacing * direction;
  return line;
}

/// B = 1 N m^2 about both directors, C = 1 N m^2 / (1 + poissons_ratio); hardly stretches under loads of about B / L^2.
inline RodSection unit_section(double poissons_ratio = 0.0, double stretch = 1e6) {
  RodSection s;
  s.stretch = stretch;
  s.bend_1 = s.bend_2 = 1.0;
  s.twist = 1.0 / (1.0 + poissons_ratio);
  s.radius_of_gyration = 0.01;
  s.linear_density = 1.0;
  return s;
}

/// Curvature about the first director, 1/m, the same at every joint of an open rod.
inline RodRest curved(double curvature, int joints, const Vec3& director) {
  RodRest rest;
  rest.curvature = Eigen::Matrix2Xd::Zero(2, joints);
  rest.curvature.row(0).setConstant(curvature);
  rest.director = director;
  return rest;
}

/// A rod of round numbers, soft enough to bend.
inline RodSection soft_section() {
  RodSection s;
  s.stretch = 300.0;
  s.bend_1 = 2.0;
  s.bend_2 = 5.0;
  s.twist = 3.0;
  s.radius_of_gyration = 0.5;
  s.linear_density = 0.7;
  return s;
}

/// Rods "rod_0", "rod_1", ... each along its line, as a scene would build them.
inline std::shared_ptr<Model> rod_model(const std::vector<Polyline>& lines, const RodSection& section,
                                        const RodRest& rest, const Vec3& gravity) {
  auto model = std::make_shared<Model>();
  int points = 0, segments = 0;
  for (const Polyline& line : lines) {
    points += static_cast<int>(line.rest.cols());
    segments += line.segment_count();
  }
  model->angle_count = segments;
  model->gravity = gravity;
  model->mass = Eigen::VectorXd::Zero(points + segments);
  State& s = model->initial;
  s.x = s.v = Nodes::Zero(3, points + segments);
  s.directors = s.tangents = Nodes::Zero(3, segments);
  s.reference_twists = Eigen::VectorXd::Zero(segments);
  int first_node = 0, first_segment = 0;
  for (const Polyline& line : lines) {
    Body body;
    body.name = "rod_" + std::to_string(model->bodies.size());
    body.kind = BodyKind::kRope;
    body.first_node = first_node;
    body.node_count = static_cast<int>(line.rest.cols());
    body.first_segment = first_segment;
    body.radius_of_gyration = section.radius_of_gyration;
    body.line = std::make_shared<Polyline>(line);
    if (!line.closed) body.features = {{"end_0", {0}}, {"end_1", {body.node_count - 1}}};
    const int count = line.segment_count();
    RodTerms terms = make_rod(line, section, rest, first_node, points + first_segment, first_segment);
    model->mass.segment(first_node, body.node_count) = line_masses(line, section.linear_density);
    model->mass.segment(points + first_segment, count) = terms.angle_masses;
    s.x.middleCols(first_node, body.node_count) = line.rest;
    s.x.block(0, points + first_segment, 1, count) = section.radius_of_gyration * terms.angles.transpose();
    s.directors.middleCols(first_segment, count) = terms.directors;
    s.tangents.middleCols(first_segment, count) = terms.tangents;
    s.reference_twists.segment(first_segment, count) = terms.reference_twists;
    for (auto& term : terms.energies) model->energies.push_back(std::move(term));
    model->bodies.push_back(std::move(body));
    first_node += static_cast<int>(line.rest.cols());
    first_segment += count;
  }
  if (!gravity.isZero()) {
    Eigen::VectorXd weight = model->mass;
    weight.tail(segments).setZero();
    model->energies.push_back(make_gravity(weight, gravity));
  }
  return model;
}

}  // namespace deformable_sim::test
