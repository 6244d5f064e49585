// A body under test: masses, terms and state in one place, without a World.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/core/integrator/integrator.h"

namespace deformable_sim::test {

constexpr double kGravity = 9.81;  // m/s^2

class System {
 public:
  System(const Nodes& x, Eigen::VectorXd masses) : mass(std::move(masses)) {
    state.x = x;
    state.v = Nodes::Zero(3, x.cols());
    dynamics.mass = &mass;
    dynamics.kinematics.target.resize(3, 0);
  }
  System(const System&) = delete;
  System& operator=(const System&) = delete;

  System& add(std::unique_ptr<Energy> term) {
    terms_.push_back(std::move(term));
    dynamics.energies.push_back(terms_.back().get());
    return *this;
  }
  System& add_springs(const SpringNetwork& network) {
    for (const auto* links : {&network.stretch, &network.shear, &network.bend}) {
      if (!links->empty()) add(make_springs("springs", *links, 0));
    }
    return *this;
  }
  System& add_gravity() { return add(make_gravity(mass, Vec3(0, 0, -kGravity))); }

  /// Holds a node where it is. Ascending order.
  System& hold(int node) {
    auto& k = dynamics.kinematics;
    k.node.push_back(node);
    k.target.conservativeResize(3, static_cast<Eigen::Index>(k.node.size()));
    k.target.rightCols<1>() = state.x.col(node);
    return *this;
  }

  /// Builds and binds the matrix pattern; `more` are pairs that contacts couple.
  void build_pattern(std::vector<std::array<int, 2>> more = {}) {
    for (const auto& term : terms_) term->add_pattern(&more);
    pattern = BlockMatrix(static_cast<int>(mass.size()), more);
    for (const auto& term : terms_) term->bind(pattern);
    dynamics.pattern = &pattern;
  }

  StepReport step(Integrator& integrator, double dt) {
    if (integrator.needs().jacobian && dynamics.pattern == nullptr) build_pattern();
    return integrator.advance(dt, &dynamics, &state);
  }

  double kinetic_energy() const { return 0.5 * state.v.colwise().squaredNorm().dot(mass); }
  double potential_energy() const {
    double sum = 0.0;
    for (const auto& term : terms_) sum += term->value(state);
    return sum;
  }
  Nodes forces() const {
    Nodes f = Nodes::Zero(3, state.x.cols());
    for (const auto& term : terms_) term->add_force(state, &f);
    return f;
  }

  Eigen::VectorXd mass;
  State state;
  Dynamics dynamics;
  BlockMatrix pattern;

 private:
  std::vector<std::unique_ptr<Energy>> terms_;
};

/// Schemes that make one step of the length they are given, whatever it is, of any force: all but substepped_verlet and
/// those that know springs and bending only, which take other forces as known.
inline std::vector<std::string> one_step_names() {
  std::vector<std::string> names = integrator_names();
  const auto others = [](const std::string& name) {
    return name == "substepped_verlet" || takes_known_terms_only(name);
  };
  names.erase(std::remove_if(names.begin(), names.end(), others), names.end());
  return names;
}

/// Implicit steps solved as exactly as double precision allows.
inline SolverSettings exact_settings(double tolerance = 1e-9) {
  SolverSettings settings;
  settings.linear = SolverSettings::Linear::kDirect;
  settings.newton_iterations = 100;
  settings.tolerance = tolerance;
  return settings;
}

/// Finds a static equilibrium: long implicit steps, each from rest. Returns the last residual (RMS, m/s^2).
inline double relax(System* system, double dt = 1.0, int steps = 60, double tolerance = 1e-7) {
  const auto integrator = make_integrator("implicit_euler", exact_settings(tolerance));
  double residual = 0.0;
  for (int k = 0; k < steps; ++k) {
    system->state.v.setZero();
    residual = system->step(*integrator, dt).residual;
  }
  system->state.v.setZero();
  return residual;
}

}  // namespace deformable_sim::test
