// Strain limits within a step: springs that pull, and only beyond their longest length.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/energy/energy.h"

namespace deformable_sim {

/// Tension t = max(0, T + k (r - l)) along each pair of nodes, r their distance, l the longest allowed:
///
///   E = t^2 / (2 k),   force on a = t n,   -df_a/dd = -(k n n^T + t/r (I - n n^T)) where t > 0
///
/// T (N) is what the limit carried in the last step, so that it is met (r = l) where nothing changes, and slackens
/// after a shortening of T / k: the augmented Lagrangian of r <= l [Hestenes 1969]. Convex: the Hessian needs no
/// projection.
class LimitSprings : public Energy {
 public:
  struct Element {
    int a, b;          // world nodes
    double longest;    // l, m
    double stiffness;  // k, N/m; 0 = out of use
    double tension;    // T, N
  };

  explicit LimitSprings(std::vector<Element> elements) : elements_(std::move(elements)) {}
  std::vector<Element>& elements() { return elements_; }
  const std::vector<Element>& elements() const { return elements_; }
  /// t at x, N.
  static double tension(const Element& e, const Nodes& x);

  std::string name() const override { return "strain limit"; }
  int element_count() const override { return static_cast<int>(elements_.size()); }
  double value(const State& s) const override;
  void add_force(const State& s, Nodes* f) const override;
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override;
  void bind(const BlockMatrix& matrix) override;
  void add_jacobian(const State& s, double dx, double dv, Jacobian kind, BlockMatrix* a) const override;

 private:
  std::vector<Element> elements_;
  std::vector<std::array<int, 4>> slots_;  // of aa, ab, ba, bb, once bound
};

}  // namespace deformable_sim
