// Constructors of the terms a model is made of. Node indices are world indices.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/material/air.h"
#include "deformable_sim/core/material/spring_network.h"
#include "deformable_sim/core/topology/polyline.h"

namespace deformable_sim {

/// Elastic and viscous force along each link: -(k (|d| - L) + c n.dv) n. `first_node` shifts the body-local link nodes.
std::unique_ptr<Energy> make_springs(const std::string& name, const std::vector<SpringLink>& links, int first_node);

/// Bending of a line that is straight without load: E = B/2 l |k|^2 a joint, k = ((x2 - x1) / b - (x1 - x0) / a) / l, a
/// and b the segments' lengths, l their mean. `rigidity` B >= 0 (N m^2), `damping` >= 0 (s): viscous over elastic
/// stiffness. Not good at: angles beyond half a radian a joint, which it finds too easy (2 sin(phi / 2) for phi);
/// natural curvature and twist, for which there are rods (rod_terms.h).
std::unique_ptr<Energy> make_line_bending(const Polyline& line, double rigidity, double damping, int first_node);

/// Uniform gravity (m/s^2); energy zero at the origin.
std::unique_ptr<Energy> make_gravity(const Eigen::VectorXd& mass, const Vec3& gravity);

/// Linear drag -rate m v (rate in 1/s).
std::unique_ptr<Energy> make_mass_damping(const Eigen::VectorXd& mass, double rate);

/// Pressure drag on triangles: 1/2 rho C_d A |u.n| (u.n) n, u the air's velocity relative to the face, a third to each
/// node.
std::unique_ptr<Energy> make_sheet_drag(const std::vector<std::array<int, 3>>& triangles, const Air& air);

/// A gauge pressure (Pa, outwards > 0) that rises from nothing in `rise` s after time 0 and is kept up, inside a closed
/// surface, whose triangles are wound counter-clockwise from outside: E = -p V. Not good at: gas that is sealed in,
/// whose pressure rises as it shrinks.
std::unique_ptr<Energy> make_pressure(const std::vector<std::array<int, 3>>& triangles, double pressure, double rise,
                                      int first_node);

/// Cross-flow drag on segments of a cylinder: 1/2 rho C_d D l |u_n| u_n, half to each end.
std::unique_ptr<Energy> make_line_drag(const std::vector<std::array<int, 2>>& segments, double diameter,
                                       const Air& air);

/// Springs from nodes to moving targets: a soft grasp. -k (x - target).
class TargetSprings : public Energy {
 public:
  TargetSprings(std::vector<int> nodes, double stiffness_per_node);
  void set_targets(const Nodes& targets);
  const std::vector<int>& nodes() const { return nodes_; }
  const Nodes& targets() const { return targets_; }
  double stiffness() const { return stiffness_; }

  std::string name() const override { return "soft grasp"; }
  int element_count() const override { return static_cast<int>(nodes_.size()); }
  double value(const State& s) const override;
  void add_force(const State& s, Nodes* f) const override;
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override;
  void bind(const BlockMatrix& matrix) override;
  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override;

 private:
  std::vector<int> nodes_;
  double stiffness_;
  Nodes targets_;
};

}  // namespace deformable_sim
