// Springs from nodes to moving targets.
#include <cassert>
#include <utility>

#include "deformable_sim/core/energy/terms.h"

namespace deformable_sim {

TargetSprings::TargetSprings(std::vector<int> nodes, double stiffness_per_node)
    : nodes_(std::move(nodes)),
      stiffness_(stiffness_per_node),
      targets_(Nodes::Zero(3, static_cast<Eigen::Index>(nodes_.size()))) {}

void TargetSprings::set_targets(const Nodes& targets) {
  assert(targets.cols() == targets_.cols());
  targets_ = targets;
}

double TargetSprings::value(const State& s) const {
  double sum = 0.0;
  for (size_t k = 0; k < nodes_.size(); ++k) {
    sum += (s.x.col(nodes_[k]) - targets_.col(static_cast<Eigen::Index>(k))).squaredNorm();
  }
  return 0.5 * stiffness_ * sum;
}

void TargetSprings::add_force(const State& s, Nodes* f) const {
  for (size_t k = 0; k < nodes_.size(); ++k) {
    f->col(nodes_[k]) -= stiffness_ * (s.x.col(nodes_[k]) - targets_.col(static_cast<Eigen::Index>(k)));
  }
}

void TargetSprings::add_pattern(std::vector<std::array<int, 2>>*) const {}

void TargetSprings::bind(const BlockMatrix&) {}

void TargetSprings::add_jacobian(const State&, double dx, double, Jacobian, BlockMatrix* a) const {
  for (int node : nodes_) a->block(a->diagonal_slot(node)).diagonal().array() += dx * stiffness_;
}

}  // namespace deformable_sim
