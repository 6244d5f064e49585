#include "specimen.h"

#include <algorithm>
#include <utility>

namespace deformable_sim::study {
namespace {

/// Constant forces on nodes.
class DeadLoad : public Energy {
 public:
  explicit DeadLoad(const Nodes& force) : force_(force) {}
  std::string name() const override { return "dead load"; }
  int element_count() const override { return static_cast<int>(force_.cols()); }
  double value(const State& s) const override { return -force_.cwiseProduct(s.x).sum(); }
  void add_force(const State&, Nodes* f) const override { *f += force_; }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}

 private:
  Nodes force_;
};

}  // namespace

Specimen::Specimen(const Nodes& rest_nodes, Eigen::VectorXd masses)
    : rest(rest_nodes),
      mass(std::move(masses)),
      held_(static_cast<size_t>(rest_nodes.size()), 0),
      loads_(Nodes::Zero(3, rest_nodes.cols())) {
  state.x = rest;
  state.v = Nodes::Zero(3, rest.cols());
}

void Specimen::add(std::unique_ptr<Energy> energy) {
  energies_.push_back(std::move(energy));
}

void Specimen::hold(int node, int axis) {
  held_[static_cast<size_t>(3 * node + axis)] = 1;
}

void Specimen::hold(int node) {
  for (int axis = 0; axis < 3; ++axis) hold(node, axis);
}

void Specimen::load(int node, const Vec3& force) {
  loads_.col(node) += force;
}

void Specimen::weigh(const Vec3& gravity, int points) {
  for (int i = 0; i < points; ++i) load(i, mass[i] * gravity);
}

Equilibrium Specimen::settle(const StaticsSettings& settings) {
  energies_.push_back(std::make_unique<DeadLoad>(loads_));
  const double largest = loads_.size() > 0 ? loads_.cwiseAbs().maxCoeff() : 0.0;
  const Equilibrium found = study::settle(energies_, held_, largest, settings, &state);
  energies_.pop_back();
  settled_ = found.converged;
  return found;
}

Nodes Specimen::reactions() const {
  return -forces_of(energies_, state) - loads_;
}

}  // namespace deformable_sim::study
