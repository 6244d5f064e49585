// Bending of a line that is straight without load and free to twist.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"
#include "deformable_sim/core/energy/quadratic_term.h"

namespace deformable_sim {

/// See make_line_bending(). Quadratic in the positions: the Jacobian is constant and its blocks are multiples of the
/// identity.
class LineBending : public Energy, public QuadraticTerm {
 public:
  struct Joint {
    std::array<int, 3> node;
    std::array<double, 3> share;  // 1/m^2: curvature = sum of shares x positions
    double stiffness;             // N m^3: B times the length the joint stands for
  };

  LineBending(std::vector<Joint> joints, double damping);
  const std::vector<Joint>& joints() const { return joints_; }
  double damping() const { return damping_; }  // s

  std::string name() const override { return "line bending"; }
  int element_count() const override { return static_cast<int>(joints_.size()); }
  double value(const State& s) const override;
  void add_force(const State& s, Nodes* f) const override;
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override;
  void bind(const BlockMatrix& matrix) override;
  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override;
  void add_entries(std::vector<Eigen::Triplet<double>>* stiffness,
                   std::vector<Eigen::Triplet<double>>* damping) const override;

 private:
  struct Entry {
    std::array<int, 2> pair;
    double weight;  // N/m
  };
  static Vec3 curvature(const Nodes& x, const Joint& j) {
    return j.share[0] * x.col(j.node[0]) + j.share[1] * x.col(j.node[1]) + j.share[2] * x.col(j.node[2]);
  }

  std::vector<Joint> joints_;
  std::vector<Entry> entries_;
  std::vector<int> slots_;  // parallel to entries_, once bound
  double damping_;          // s
};

}  // namespace deformable_sim
