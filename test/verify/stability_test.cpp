// The step limits of explicit schemes are those of theory, computed from the highest frequency of the body itself.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

/// Growth of a tiny random disturbance of the rest state, in `steps` steps. Infinite when the state is.
double growth(const std::string& scheme, System* body, double dt, int steps) {
  const Nodes rest = body->state.x;
  std::mt19937 generator(5);
  std::normal_distribution<double> normal(0.0, 1e-9);
  body->state.v.setZero();
  body->state.x += Nodes::NullaryExpr(3, rest.cols(), [&] { return normal(generator); });
  for (int node : body->dynamics.kinematics.node) body->state.x.col(node) = rest.col(node);
  const auto energy = [&] { return body->kinetic_energy() + body->potential_energy(); };
  const double start = energy();
  const auto integrator = make_integrator(scheme, exact_settings());
  for (int k = 0; k < steps; ++k) {
    body->step(*integrator, dt);
    if (!body->state.finite() || energy() > 1e6 * start) return std::numeric_limits<double>::infinity();
  }
  const double end = energy();
  body->state.x = rest;
  return std::sqrt(end / start);
}

std::unique_ptr<System> chain() {
  const Polyline line = make_line(1.0, 20);
  LineStiffness stiffness;
  stiffness.axial = 50.0;
  auto body = std::make_unique<System>(line.rest, line_masses(line, 0.1));
  body->add_springs(line_network(line, stiffness)).hold(0);
  return body;
}

std::unique_ptr<System> grid() {
  const TriangleMesh mesh = make_grid(0.6, 0.5, 8, 7);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  auto body = std::make_unique<System>(mesh.rest, sheet_masses(mesh, 0.2));
  body->add_springs(sheet_network(mesh, stiffness)).hold(0);
  return body;
}

TEST(ExplicitSchemes, AreBoundedBelowTheirLimitAndDivergeAboveIt) {
  // omega_max dt = 2 (symplectic Euler, Verlet), 2 sqrt 2 (Runge-Kutta): 2 % below stays bounded, 2 % above grows.
  for (const std::string& scheme : integrator_names()) {
    const double limit = make_integrator(scheme, {})->stability_limit();
    if (limit == 0.0 || std::isinf(limit)) continue;
    for (auto* make : {&chain, &grid}) {
      auto body = (*make)();
      const double omega = highest_frequency(body->dynamics, body->state);
      EXPECT_LT(growth(scheme, body.get(), 0.98 * limit / omega, 3000), 20.0) << scheme;
      EXPECT_GT(growth(scheme, (*make)().get(), 1.02 * limit / omega, 3000), 1e3) << scheme;
    }
  }
}

TEST(ExplicitEuler, NeedsDampingAndThenHasTheLimitOfTheory) {
  // dt < 2 zeta / omega; with dampers c = tau k, zeta = tau omega / 2, so dt < tau for every mode with zeta < 1.
  const Polyline line = make_line(1.0, 20);
  const auto damped = [&](double tau) {
    LineStiffness stiffness;
    stiffness.axial = 50.0;
    stiffness.damping_time = tau;
    auto body = std::make_unique<System>(line.rest, line_masses(line, 0.1));
    body->add_springs(line_network(line, stiffness)).hold(0);
    return body;
  };
  auto undamped = damped(0.0);
  const double omega = highest_frequency(undamped->dynamics, undamped->state);
  EXPECT_EQ(make_integrator("explicit_euler", {})->stability_limit(), 0.0);
  EXPECT_GT(growth("explicit_euler", undamped.get(), 0.1 / omega, 3000), 1e3);
  const double tau = 0.5 / omega;
  EXPECT_LT(growth("explicit_euler", damped(tau).get(), 0.98 * tau, 8000), 1.5);
  EXPECT_GT(growth("explicit_euler", damped(tau).get(), 1.02 * tau, 8000), 1e3);
}

TEST(ImplicitSchemes, AreBoundedAtAHundredTimesTheExplicitLimit) {
  for (const std::string& scheme : integrator_names()) {
    if (!std::isinf(make_integrator(scheme, {})->stability_limit())) continue;
    auto body = grid();
    const double omega = highest_frequency(body->dynamics, body->state);
    EXPECT_LT(growth(scheme, body.get(), 200.0 / omega, 200), 1.0 + 1e-6) << scheme;
  }
}

}  // namespace
}  // namespace deformable_sim::test
