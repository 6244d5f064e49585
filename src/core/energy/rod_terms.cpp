#include "deformable_sim/core/energy/rod_terms.h"

#include <cmath>
#include <string>
#include <utility>

#include "deformable_sim/core/element/rod_joint.h"
#include "deformable_sim/core/energy/element_energy.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/rod_frames.h"

namespace deformable_sim {
namespace {

/// The joints of one rod, which also carry its frames from step to step.
class RodJoints : public ElementEnergy<RodJoint> {
 public:
  RodJoints(std::vector<Element> joints, int first_segment, int segment_count, int first_node, bool closed)
      : ElementEnergy("rod bend and twist", std::move(joints), {}),
        first_segment_(first_segment),
        segment_count_(segment_count),
        first_node_(first_node),
        closed_(closed) {}

  void end_step(State* s) const override { carry_frames(first_segment_, segment_count_, first_node_, closed_, s); }

 private:
  int first_segment_, segment_count_, first_node_;
  bool closed_;
};

void require(bool good, const std::string& what, const std::string& allowed) {
  if (!good) throw InputError(what + " must be " + allowed);
}

void check(const Polyline& line, const RodSection& s, const RodRest& rest) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  const auto not_negative = [](double value) { return std::isfinite(value) && value >= 0.0; };
  require(positive(s.stretch), "the rod's stretch stiffness EA", "finite and > 0 (N)");
  require(not_negative(s.bend_1) && not_negative(s.bend_2), "the rod's bending stiffnesses", "finite and >= 0 (N m^2)");
  require(not_negative(s.twist), "the rod's twist stiffness GJ", "finite and >= 0 (N m^2)");
  require(not_negative(s.damping), "the rod's damping", "finite and >= 0 (s)");
  require(positive(s.radius_of_gyration), "the rod's radius of gyration", "finite and > 0 (m)");
  require(positive(s.linear_density), "the rod's linear density", "finite and > 0 (kg/m)");
  require(line.segment_count() >= (line.closed ? 3 : 1), "a rod", "at least one segment, three when closed");
  const Eigen::Index joints = line.closed ? line.rest.cols() : line.rest.cols() - 2;
  const std::string sizes = "one value a joint (" + std::to_string(joints) + ") or none";
  require(rest.curvature.cols() == 0 || rest.curvature.cols() == joints, "the rod's curvature", sizes);
  require(rest.twist.size() == 0 || rest.twist.size() == joints, "the rod's rest twist", sizes);
  require(rest.curvature.allFinite() && rest.twist.allFinite() && rest.director.allFinite(), "the rod's rest shape",
          "finite");
  for (int k = 0; k < line.segment_count(); ++k) {
    const auto [a, b] = line.segment(k);
    require(positive((line.rest.col(b) - line.rest.col(a)).norm()), "segment " + std::to_string(k) + " of the rod",
            "finite and longer than 0 m");
  }
}

int joint_count(const Polyline& line) {
  return line.segment_count() - (line.closed ? 0 : 1);
}

Eigen::VectorXd lengths_of(const Polyline& line) {
  Eigen::VectorXd length(line.segment_count());
  for (int k = 0; k < line.segment_count(); ++k) {
    const auto [a, b] = line.segment(k);
    length[k] = (line.rest.col(b) - line.rest.col(a)).norm();
  }
  return length;
}

/// Half the length of both segments at joint k, m.
double joint_length(const Eigen::VectorXd& length, int k) {
  return 0.5 * (length[k] + length[(k + 1) % length.size()]);
}

/// The strains of an unloaded joint: the curvature is given in the frame half-way between those of its segments, which
/// are turned from it by half the twist each.
std::array<double, RodJoint::kStrains> rest_strains(const Eigen::Vector2d& curvature, double twist, double length) {
  const double turn = curvature.norm() * length;
  require(turn < 3.0, "the rod's rest curvature", "less than 3 rad a joint; use more segments");
  const Eigen::Vector2d k = turn > 0.0 ? Eigen::Vector2d(RodCurvature::of_turn(turn) / curvature.norm() * curvature)
                                       : Eigen::Vector2d::Zero();
  const double c = std::cos(0.5 * twist), s = std::sin(0.5 * twist);
  return {c * k[0] - s * k[1], c * k[1] + s * k[0], c * k[0] + s * k[1], c * k[1] - s * k[0], twist};
}

/// Angles that give every joint its rest twist over the reference one; what a closed rod has left is spread evenly.
Eigen::VectorXd initial_angles(const Polyline& line, const Eigen::VectorXd& twist,
                               const Eigen::VectorXd& reference_twists) {
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(line.segment_count());
  const double excess = line.closed ? (twist - reference_twists).sum() / static_cast<double>(twist.size()) : 0.0;
  for (Eigen::Index k = 0; k + 1 < angles.size(); ++k) {
    angles[k + 1] = angles[k] + twist[k] - reference_twists[k] - excess;
  }
  return angles;
}

std::unique_ptr<Energy> make_stretch(const Polyline& line, const RodSection& section, const Eigen::VectorXd& length,
                                     int first_node) {
  std::vector<SpringLink> links;
  for (int k = 0; k < line.segment_count(); ++k) {
    const auto [a, b] = line.segment(k);
    const double stiffness = section.stretch / length[k];
    links.push_back({a, b, length[k], stiffness, section.damping * stiffness});
  }
  return make_springs("rod stretch springs", links, first_node);
}

}  // namespace

RodTerms make_rod(const Polyline& line, const RodSection& section, const RodRest& rest, int first_node, int first_angle,
                  int first_segment) {
  check(line, section, rest);
  const int joints = joint_count(line), segments = line.segment_count(), nodes = static_cast<int>(line.rest.cols());
  const Eigen::VectorXd length = lengths_of(line);
  RodFrames frames = rod_frames(line, rest.director);

  Eigen::VectorXd twist = Eigen::VectorXd::Zero(joints);
  std::vector<ElementEnergy<RodJoint>::Element> elements;
  for (int k = 0; k < joints; ++k) {
    const double l = joint_length(length, k);
    const Eigen::Vector2d curvature =
        rest.curvature.cols() > 0 ? Eigen::Vector2d(rest.curvature.col(k)) : Eigen::Vector2d::Zero();
    if (rest.twist.size() > 0) twist[k] = rest.twist[k] * l;
    const int next = (k + 1) % segments;
    RodJoint::Rest joint;
    joint.strain = rest_strains(curvature, twist[k], l);
    const double bend_1 = 0.5 * section.bend_1 / l, bend_2 = 0.5 * section.bend_2 / l;
    joint.weight = {bend_1, bend_2, bend_1, bend_2, section.twist / l};
    joint.damping = section.damping;
    joint.radius_of_gyration = section.radius_of_gyration;
    joint.segment_a = first_segment + k;
    joint.segment_b = first_segment + next;
    elements.push_back({{first_node + k, first_node + (k + 1) % nodes, first_node + (k + 2) % nodes, first_angle + k,
                         first_angle + next},
                        joint});
  }

  RodTerms terms;
  terms.angles = initial_angles(line, twist, frames.reference_twists);
  terms.energies.push_back(make_stretch(line, section, length, first_node));
  if (joints > 0) {
    terms.energies.push_back(
        std::make_unique<RodJoints>(std::move(elements), first_segment, segments, first_node, line.closed));
  }
  terms.directors = std::move(frames.directors);
  terms.tangents = std::move(frames.tangents);
  terms.reference_twists = std::move(frames.reference_twists);
  terms.angle_masses = section.linear_density * length;
  return terms;
}

RodSection circular_section(double diameter, double youngs_modulus, double poissons_ratio, double density,
                            double inner_diameter) {
  require(std::isfinite(diameter) && diameter > 0.0, "the rod's diameter", "finite and > 0 (m)");
  require(inner_diameter >= 0.0 && inner_diameter < diameter, "the rod's inner diameter", ">= 0 and below the outer");
  require(std::isfinite(youngs_modulus) && youngs_modulus > 0.0, "Young's modulus", "finite and > 0 (Pa)");
  require(poissons_ratio > -1.0 && poissons_ratio <= 0.5, "Poisson's ratio", "above -1 and at most 0.5");
  require(std::isfinite(density) && density > 0.0, "the density", "finite and > 0 (kg/m^3)");
  const double pi = std::acos(-1.0), r = 0.5 * diameter, q = 0.5 * inner_diameter;
  const double area = pi * (r * r - q * q), second_moment = pi / 4.0 * (r * r * r * r - q * q * q * q);
  RodSection s;
  s.stretch = youngs_modulus * area;
  s.bend_1 = s.bend_2 = youngs_modulus * second_moment;
  s.twist = youngs_modulus / (1.0 + poissons_ratio) * second_moment;
  s.radius_of_gyration = std::sqrt(2.0 * second_moment / area);
  s.linear_density = density * area;
  return s;
}

RodRest rest_as_drawn(const Polyline& line, const Vec3& director) {
  const RodFrames frames = rod_frames(line, director);
  const Eigen::VectorXd length = lengths_of(line);
  const int joints = joint_count(line);
  RodRest rest;
  rest.director = frames.directors.col(0);
  rest.curvature = Eigen::Matrix2Xd::Zero(2, joints);
  const auto segments = static_cast<int>(length.size());
  const double excess = line.closed ? frames.reference_twists[segments - 1] / static_cast<double>(joints) : 0.0;
  for (int k = 0; k < joints; ++k) {
    const Vec3 a = frames.tangents.col(k), b = frames.tangents.col((k + 1) % segments);
    const Vec3 binormal = a.cross(b);
    const double sine = binormal.norm();
    if (sine == 0.0) continue;
    const double turn = std::atan2(sine, a.dot(b));
    const Vec3 axis = (turn / (sine * joint_length(length, k))) * binormal;
    // The frame half-way: that of segment a, turned by the initial angles (see make_rod) of a and half of b's.
    const double angle = (k + 0.5) * excess;
    const Vec3 u = frames.directors.col(k), v = a.cross(u);
    rest.curvature(0, k) = axis.dot(std::cos(angle) * u + std::sin(angle) * v);
    rest.curvature(1, k) = axis.dot(std::cos(angle) * v - std::sin(angle) * u);
  }
  return rest;
}

}  // namespace deformable_sim
