// Rods with stretch, bend and twist: discrete elastic rods.
#pragma once

#include <memory>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/topology/polyline.h"

namespace deformable_sim {

/// The section of a rod, uniform along it. A solid circle of radius r: EA = E pi r^2, EI = E pi r^4 / 4 about both
/// directors, GJ = G pi r^4 / 2, radius of gyration r / sqrt(2).
struct RodSection {
  double stretch = 0.0;             // EA, N, > 0
  double bend_1 = 0.0;              // E I, N m^2, >= 0: stiffness against curvature about the first director
  double bend_2 = 0.0;              // E I, N m^2, >= 0: about the second director, tangent x first
  double twist = 0.0;               // GJ, N m^2, >= 0
  double damping = 0.0;             // s, >= 0: every strain rate is resisted by damping times its stiffness
  double radius_of_gyration = 0.0;  // m, > 0, polar: sqrt((I_1 + I_2) / A)
  double linear_density = 0.0;      // kg/m, > 0; only for the inertia of spin
};

/// The shape a rod has without load. A joint is a node between two segments; joint k lies between segment k and the
/// next one, so that an open rod of n nodes has n - 2 and a closed one n.
struct RodRest {
  Eigen::Matrix2Xd curvature;    // 1/m about the two directors, per joint; empty: straight
  Eigen::VectorXd twist;         // rad/m, per joint; empty: none
  Vec3 director = Vec3::Zero();  // first director of the first segment, made normal to it; zero: any
};

struct RodTerms {
  std::vector<std::unique_ptr<Energy>> energies;  // stretch; bend and twist, where there is a joint
  Nodes directors, tangents;                      // 3 x segments, for State
  Eigen::VectorXd reference_twists;               // 1 x segments, for State
  Eigen::VectorXd angles;                         // rad, 1 x segments: the initial angle of each segment
  Eigen::VectorXd angle_masses;                   // kg, 1 x segments: those of the angle columns
};

/// Terms of one rod, which starts as `line` lies; rest lengths are those of the line. Its nodes are the world nodes
/// first_node + i, the angle of its segment j is the column first_angle + j, and its frames are the columns
/// first_segment + j of State's.
/// The initial angles give the rod its rest twist; a closed rod spreads what does not fit evenly over its joints.
/// Throws InputError for negative or non-finite stiffnesses, wrong sizes and segments without length.
RodTerms make_rod(const Polyline& line, const RodSection& section, const RodRest& rest, int first_node, int first_angle,
                  int first_segment);

/// A solid or hollow circular section: outer diameter and inner one (m), Young's modulus (Pa), Poisson's ratio,
/// density (kg/m^3).
RodSection circular_section(double diameter, double youngs_modulus, double poissons_ratio, double density,
                            double inner_diameter = 0.0);

/// The curvatures and twists of `line` as it lies, its material frame carried along without twist from `director`: a
/// rod of this rest shape is free of stress there (a closed one that is not planar keeps the twist that its closure
/// asks for).
RodRest rest_as_drawn(const Polyline& line, const Vec3& director = Vec3::Zero());

}  // namespace deformable_sim
