// Ropes of a scene as chains of springs or as rods.
#include <algorithm>
#include <cmath>

#include "build_parts.h"
#include "deformable_sim/core/energy/terms.h"
#include "features.h"

namespace deformable_sim {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kShearOfYoungs = 1.0 / 2.6;  // G / E at a Poisson's ratio of 0.3

/// Area (m^2), second moments about y and z, and torsion constant (m^4) of a section.
struct SectionShape {
  double area, about_y, about_z, torsion;
};

SectionShape round_section(double diameter) {
  const double r = 0.5 * diameter, fourth = kPi * r * r * r * r / 4.0;
  return {kPi * r * r, fourth, fourth, 2.0 * fourth};
}

/// J = a b^3 (1/3 - 64/pi^5 b/a sum over odd n of tanh(n pi a / (2 b)) / n^5), a >= b [Timoshenko Goodier 1970].
SectionShape rectangular_section(double width, double height) {
  const double a = std::max(width, height), b = std::min(width, height);
  double sum = 0.0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(0.5 * n * kPi * a / b) / std::pow(n, 5);
  const double torsion = a * b * b * b * (1.0 / 3.0 - 64.0 / std::pow(kPi, 5) * b / a * sum);
  return {width * height, width * std::pow(height, 3) / 12.0, height * std::pow(width, 3) / 12.0, torsion};
}

SectionShape shape_of(const RopeMaterialSpec& m) {
  return m.section ? rectangular_section((*m.section)[0], (*m.section)[1]) : round_section(m.diameter);
}

RodSection section_of(const RopeMaterialSpec& m) {
  const SectionShape shape = shape_of(m);
  RodSection section;
  section.stretch = m.axial_stiffness.value_or(m.youngs_modulus * shape.area);
  const std::array<double, 2> bending = m.bending_rigidity.value_or(
      std::array<double, 2>{{m.youngs_modulus * shape.about_y, m.youngs_modulus * shape.about_z}});
  section.bend_1 = bending[0];
  section.bend_2 = bending[1];
  const double shear_modulus = m.shear_modulus.value_or(kShearOfYoungs * m.youngs_modulus);
  section.twist = m.twist_rigidity.value_or(shear_modulus * shape.torsion);
  section.damping = m.damping;
  section.radius_of_gyration = std::sqrt((shape.about_y + shape.about_z) / shape.area);
  section.linear_density = m.linear_density;
  return section;
}

/// The shape without load, its centroid at the origin: begins along x, every joint turned by its curvature and twist.
Polyline natural_line(const BodySpec& spec) {
  Polyline line = make_line(spec.length, spec.segments);
  const double l = spec.length / spec.segments;
  const Vec3 curvature(0.0, spec.rope.natural_curvature[0], spec.rope.natural_curvature[1]);
  const Mat3 half_twist = Eigen::AngleAxisd(0.5 * spec.rope.natural_twist * l, Vec3::UnitX()).toRotationMatrix();
  Mat3 bend = Mat3::Identity();
  if (curvature.norm() > 0.0) bend = Eigen::AngleAxisd(curvature.norm() * l, curvature.normalized()).toRotationMatrix();
  const Mat3 joint = half_twist * bend * half_twist;
  Mat3 frame = Mat3::Identity();
  for (int k = 0; k < spec.segments; ++k) {
    line.rest.col(k + 1) = line.rest.col(k) + l * frame.col(0);
    frame = frame * joint;
  }
  const Vec3 centroid = line.rest.rowwise().mean();
  line.rest.colwise() -= centroid;
  return line;
}

RodRest rest_of(const RopeModelSpec& spec, const Polyline& line, const Pose& world_from_body) {
  const Eigen::Index joints = line.segment_count() - (line.closed ? 0 : 1);
  RodRest rest;
  const Eigen::Vector2d curvature(spec.natural_curvature[0], spec.natural_curvature[1]);
  if (!curvature.isZero(0.0)) rest.curvature = curvature.replicate(1, joints);
  if (spec.natural_twist != 0.0) rest.twist = Eigen::VectorXd::Constant(joints, spec.natural_twist);
  // The second director is z, so that the plane the body is drawn in is the one it curves in.
  const Vec3 tangent = line.rest.col(1) - line.rest.col(0);
  rest.director = world_from_body.linear() * Vec3::UnitZ().cross(tangent).normalized();
  return rest;
}

void add_rod(const BodySpec& spec, const Polyline& line, Body* body, Parts* parts) {
  const Pose pose = spec.pose.pose();
  Parts::Rod rod{parts->positions.size(), line, section_of(spec.rope_material), rest_of(spec.rope, line, pose),
                 spec.rope.initial_twist};
  rod.line.rest = (pose.linear() * line.rest).colwise() + Vec3(pose.translation());
  body->radius_of_gyration = rod.section.radius_of_gyration;
  for (int s = 0; s < line.segment_count(); ++s) {
    const auto [a, b] = line.segment(s);
    const double length = (line.rest.col(b) - line.rest.col(a)).norm();
    body->strain_edges.push_back({{a + body->first_node, b + body->first_node}, length});
  }
  parts->rods.push_back(std::move(rod));
}

/// E A of a chain of springs, N.
double chain_stiffness(const RopeMaterialSpec& m) {
  return m.axial_stiffness.value_or(m.youngs_modulus * 0.25 * kPi * m.diameter * m.diameter);
}

void add_springs(const BodySpec& spec, const Polyline& line, Body* body, Parts* parts) {
  const RopeMaterialSpec& material = spec.rope_material;
  LineStiffness stiffness;
  stiffness.axial = chain_stiffness(material);
  stiffness.stretch = material.stretch_stiffness;
  stiffness.bend = spec.rope.model == RopeModel::kUntwisted ? 0.0 : material.bend_stiffness;
  stiffness.damping_time = material.damping;
  const SpringNetwork network = line_network(line, stiffness);
  append_network(network, body->first_node, parts);
  add_strain_edges(network.stretch, body);
  if (spec.rope.model == RopeModel::kUntwisted) {
    parts->terms.push_back(make_line_bending(line, section_of(material).bend_1, material.damping, body->first_node));
  }
  if (material.bending_rigidity && spec.rope.model == RopeModel::kSprings) {
    parts->notes.push_back("body " + spec.name + ": a chain of springs has no bending and no twisting stiffness; " +
                           material.name + " has; model: untwisted or rod shows it");
  }
}

/// Nodes at their distances at rest, along a path of the same length.
Nodes along(const std::vector<Vec3>& path, const Polyline& line) {
  Nodes x(3, line.rest.cols());
  size_t leg = 1;
  double passed = 0.0;  // before this leg
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double at = (line.rest.col(i) - line.rest.col(0)).norm();
    while (leg + 1 < path.size() && at > passed + (path[leg] - path[leg - 1]).norm()) {
      passed += (path[leg] - path[leg - 1]).norm();
      ++leg;
    }
    x.col(i) = path[leg - 1] + (at - passed) * (path[leg] - path[leg - 1]).normalized();
  }
  return x;
}

}  // namespace

double segments_per_second(const BodySpec& rope) {
  const RopeMaterialSpec& m = rope.rope_material;
  const double segment = rope.length / rope.segments;
  const double stiffness = rope.rope.model == RopeModel::kRod ? section_of(m).stretch
                           : m.stretch_stiffness              ? *m.stretch_stiffness * segment
                                                              : chain_stiffness(m);
  return std::sqrt(stiffness / m.linear_density) / segment;
}

void add_rope(const BodySpec& spec, Body* body, Parts* parts) {
  const RopeMaterialSpec& material = spec.rope_material;
  const bool rod = spec.rope.model == RopeModel::kRod;
  const Polyline line = spec.closed                                     ? make_ring(spec.length, spec.segments)
                        : rod && spec.rope.start == RopeStart::kNatural ? natural_line(spec)
                                                                        : make_line(spec.length, spec.segments);
  if (rod) {
    add_rod(spec, line, body, parts);
  } else {
    add_springs(spec, line, body, parts);
  }
  const double thinnest =
      material.section ? std::min((*material.section)[0], (*material.section)[1]) : material.diameter;
  Parts::Line segments{{}, material.section ? (*material.section)[0] : material.diameter};
  for (int s = 0; s < line.segment_count(); ++s) {
    const std::array<int, 2> ends = line.segment(s);
    segments.segments.push_back({ends[0] + body->first_node, ends[1] + body->first_node});
  }
  parts->lines.push_back(std::move(segments));
  place_nodes(spec.path.empty() ? line.rest : along(spec.path, line), spec.pose.pose(),
              line_masses(line, material.linear_density), body, parts);
  if (material.elastic_limit) body->valid_strain[1] = *material.elastic_limit;
  // A chord between two nodes would cut a round collider deeper than a rope is thick.
  body->contact_at_faces = true;
  body->contact_radius = spec.contact_radius.value_or(std::max(0.5 * thinnest, kMinContactRadius));
  body->draw_radius = 0.5 * thinnest;
  body->features = line_features(line);
  body->line = std::make_shared<Polyline>(line);
}

}  // namespace deformable_sim
