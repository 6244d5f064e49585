// Time schemes against closed forms: free fall, the linear oscillator, the pendulum, conservation, order.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

constexpr double kOmega = 20.0;  // rad/s, of the oscillator below

/// One mass on a spring along x, held at the other end: linear as long as it moves along x.
std::unique_ptr<System> oscillator(double elongation) {
  auto system = std::make_unique<System>((Nodes(3, 2) << 0, 1, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 0.5));
  system->add(make_springs("spring", {{0, 1, 1.0, 0.5 * kOmega * kOmega, 0.0}}, 0)).hold(0);
  system->state.x(0, 1) += elongation;
  return system;
}

TEST(FreeFall, FollowsTheExactRecurrenceOfEachScheme) {
  // z(t) = -g t (t - dt) / 2 explicit Euler, -g t (t + dt) / 2 symplectic and implicit Euler, -g t^2 / 2 all schemes of
  // second and higher order.
  const double dt = 0.01;
  const int steps = 100;
  const double t = dt * steps;
  const std::map<std::string, double> expected = {{"explicit_euler", -0.5 * kGravity * t * (t - dt)},
                                                  {"symplectic_euler", -0.5 * kGravity * t * (t + dt)},
                                                  {"rk4", -0.5 * kGravity * t * t},
                                                  {"velocity_verlet", -0.5 * kGravity * t * t},
                                                  {"substepped_verlet", -0.5 * kGravity * t * t},
                                                  {"line_dual", -0.5 * kGravity * t * t},
                                                  {"projective_dynamics", -0.5 * kGravity * t * (t + dt)},
                                                  {"xpbd", -0.5 * kGravity * t * (t + dt)},
                                                  {"implicit_euler", -0.5 * kGravity * t * (t + dt)},
                                                  {"linear_implicit_euler", -0.5 * kGravity * t * (t + dt)},
                                                  {"implicit_midpoint", -0.5 * kGravity * t * t},
                                                  {"bdf2", -0.5 * kGravity * t * t},
                                                  {"tr_bdf2", -0.5 * kGravity * t * t}};
  const TriangleMesh mesh = make_grid(0.5, 0.4, 4, 3);
  SheetStiffness stiffness;
  stiffness.membrane = 20.0;
  stiffness.damping_time = 1e-3;
  for (const std::string& name : integrator_names()) {
    ASSERT_TRUE(expected.count(name)) << name << " needs its free-fall formula here";
    System sheet(mesh.rest, sheet_masses(mesh, 0.15));
    sheet.add_springs(sheet_network(mesh, stiffness)).add_gravity();
    const auto integrator = make_integrator(name, exact_settings(1e-10));
    for (int k = 0; k < steps; ++k) sheet.step(*integrator, dt);
    const Nodes fallen = sheet.state.x - mesh.rest;
    // Explicit Euler without enough damping amplifies rounding: 1e-8; the others to 1e-10.
    const double tolerance = name == "explicit_euler" ? 1e-8 : 1e-10;
    EXPECT_LT((fallen.row(2).array() - expected.at(name)).abs().maxCoeff(), tolerance) << name;
    EXPECT_LT(fallen.topRows<2>().cwiseAbs().maxCoeff(), tolerance) << name;
  }
}

TEST(Oscillator, SwingsWithThePeriodOfItsSpring) {
  // T = 2 pi / omega; the phase error of RK4 is (omega dt)^4 / 120 = 1e-9.
  auto system = oscillator(0.01);
  const auto integrator = make_integrator("rk4", {});
  const int steps = 1000;
  for (int k = 0; k < steps; ++k) system->step(*integrator, 2.0 * M_PI / kOmega / steps);
  EXPECT_NEAR(system->state.x(0, 1) - 1.0, 0.01, 1e-10);
  EXPECT_NEAR(system->state.v(0, 1), 0.0, 1e-8);
}

TEST(SymplecticEulerOscillator, KeepsItsInvariantToRounding) {
  // v^2 + omega^2 x^2 - dt omega^2 x v is conserved exactly, at every step size below the limit.
  auto system = oscillator(0.01);
  const double dt = 0.5 / kOmega;
  const auto integrator = make_integrator("symplectic_euler", {});
  const auto invariant = [&] {
    const double x = system->state.x(0, 1) - 1.0, v = system->state.v(0, 1);
    return v * v + kOmega * kOmega * (x * x - dt * x * v);
  };
  const double start = invariant();
  for (int k = 0; k < 100000; ++k) system->step(*integrator, dt);
  EXPECT_NEAR(invariant(), start, 1e-9 * start);
}

/// Full period of a pendulum of 1 m on a stiff spring, from the time between two passages through the vertical.
double pendulum_period(double degrees) {
  const double angle = degrees * M_PI / 180.0, dt = 2e-4;
  System system((Nodes(3, 2) << 0, std::sin(angle), 0, 0, 0, -std::cos(angle)).finished(), Eigen::Vector2d(1, 1));
  system.add(make_springs("rod", {{0, 1, 1.0, 1e6, 10.0}}, 0)).add_gravity().hold(0);
  const auto integrator = make_integrator("rk4", {});
  std::vector<double> passages;
  while (passages.size() < 2 && system.state.time < 10.0) {
    const double before = system.state.x(0, 1);
    system.step(*integrator, dt);
    const double after = system.state.x(0, 1);
    if (before * after < 0.0) passages.push_back(system.state.time - dt * after / (after - before));
  }
  return passages.size() < 2 ? 0.0 : 2.0 * (passages[1] - passages[0]);
}

TEST(Pendulum, SwingsWithThePeriodOfTheEllipticIntegral) {
  // T / T0 = 2 K(sin(theta / 2)) / pi, T0 = 2 pi sqrt(L / g). The spring stretches by less than 6 m g / k = 6e-5.
  const double small = 2.0 * M_PI / std::sqrt(kGravity);
  for (const double degrees : {10.0, 90.0, 150.0}) {
    const double expected = 2.0 / M_PI * std::comp_ellint_1(std::sin(degrees * M_PI / 360.0));
    EXPECT_NEAR(pendulum_period(degrees) / small, expected, 2e-4 * expected) << degrees;
  }
}

TEST(FreeSheet, NeverGainsEnergyFromDamping) {
  const TriangleMesh mesh = make_grid(0.5, 0.4, 5, 4);
  SheetStiffness stiffness;
  stiffness.membrane = 50.0;
  stiffness.damping_time = 5e-3;
  System sheet(mesh.rest, sheet_masses(mesh, 0.15));
  sheet.add_springs(sheet_network(mesh, stiffness));
  sheet.state.x.row(0) *= 1.1;
  const auto integrator = make_integrator("implicit_euler", exact_settings(1e-10));
  double before = sheet.kinetic_energy() + sheet.potential_energy();
  const double start = before;
  for (int k = 0; k < 100; ++k) {
    sheet.step(*integrator, 2e-3);
    const double after = sheet.kinetic_energy() + sheet.potential_energy();
    EXPECT_LE(after, before + 1e-12 * start);
    before = after;
  }
  EXPECT_LT(before, 0.5 * start);
}

}  // namespace
}  // namespace deformable_sim::test
