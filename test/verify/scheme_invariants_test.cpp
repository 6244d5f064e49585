// E2 on a real spring, E3, E4: what rotation, energy and momenta become under each scheme.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/system.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// The angle turned in the last of `steps` steps of two masses on a spring of 1 m, both 1 kg, dt = 1 s.
double last_angle(double first, int steps, double stiffness) {
  const Vec3 axis = Vec3(1, 2, 3).normalized(), arm = 0.5 * axis.cross(Vec3(0, 0, 1)).normalized();
  System pair((Nodes(3, 2) << arm, -arm).finished(), Eigen::Vector2d(1, 1));
  pair.add(make_springs("bond", {{0, 1, 1.0, stiffness, 0.0}}, 0));
  pair.state.v.col(0) = arm - Eigen::AngleAxisd(-first, axis) * arm;  // the chord of the step before
  pair.state.v.col(1) = -pair.state.v.col(0);
  const auto integrator = make_integrator("implicit_euler", exact_settings(1e-14 * first + 2e-16 * stiffness));
  double turned = 0.0;
  for (int k = 0; k < steps; ++k) {
    const Vec3 before = pair.state.x.col(0) - pair.state.x.col(1);
    pair.step(*integrator, 1.0);
    const Vec3 after = pair.state.x.col(0) - pair.state.x.col(1);
    turned = std::atan2(before.cross(after).norm(), before.dot(after));
  }
  return turned;
}

TEST(ImplicitEulerRotation, SlowsDownAsTheRecurrenceSays) {
  // Two masses on a rigid bond: phi' = atan(sin phi / (2 - cos phi)), phi the angle turned in a step; about
  // 1 / sqrt(1 + 2 n (omega dt)^2). The bond gives by some m omega^2 / k = 1e-5 of its length: extrapolated to
  // k = infinity, with an error of the third power. The chord of a step is known to 1e-16 / phi, which the
  // extrapolation multiplies by fifteen and the steps add up.
  for (const TableRow& row : read_rows("E4_implicit_euler_rigid_rotation_decay.csv")) {
    const double first = row("omega0*dt");
    const int steps = static_cast<int>(row("steps"));
    const double k = 1e5 * first * first;
    const double rigid = (last_angle(first, steps, k) - 6.0 * last_angle(first, steps, 2.0 * k) +
                          8.0 * last_angle(first, steps, 4.0 * k)) /
                         3.0;
    check("E3", "turning rate left after " + row.text("steps") + " steps of omega dt = " + row.text("omega0*dt"),
          rigid / first, row("omega_n/omega_0 (stiff-bond limit, chord velocity)"), steps > 100 ? 1e-10 : 5e-12,
          Tolerance::kAbsolute);
  }
}

TEST(ImplicitEulerSpring, LosesTheFactorOfTheoryEachStep) {
  // (x, v / omega) shrinks by 1 / sqrt(1 + (omega dt)^2) each step, on one stretched spring.
  const double omega = 20.0;
  for (const double dt : {1e-3, 1e-2, 0.1}) {
    System body((Nodes(3, 2) << 0, 1.2, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 0.5));
    body.add(make_springs("spring", {{0, 1, 1.0, 0.5 * omega * omega, 0.0}}, 0)).hold(0);
    const auto integrator = make_integrator("implicit_euler", exact_settings(1e-12));
    body.step(*integrator, dt);
    check("E2", "amplitude per step of a spring at omega dt " + std::to_string(omega * dt),
          std::hypot(body.state.x(0, 1) - 1.0, body.state.v(0, 1) / omega) / 0.2,
          1.0 / std::sqrt(1.0 + omega * omega * dt * dt), 1e-10);
  }
}

/// Relative energies of an oscillator (omega = 1, started at x = 1) under a scheme, step by step.
template <class Visit>
void follow_energy(const std::string& scheme, double dt, int steps, const Visit& visit) {
  System body((Nodes(3, 2) << 0, 1.25, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 1.0));
  body.add(make_springs("spring", {{0, 1, 1.0, 1.0, 0.0}}, 0)).hold(0);
  const auto integrator = make_integrator(scheme, exact_settings(1e-14));
  for (int k = 0; k < steps; ++k) {
    body.step(*integrator, dt);
    const double x = body.state.x(0, 1) - 1.0, v = body.state.v(0, 1);
    visit(k, (x * x + v * v) / (0.25 * 0.25));
  }
}

TEST(SymplecticEuler, KeepsItsEnergyInTheBandOfTheory) {
  // v^2 + x^2 - h x v is conserved, hence |E - E0| / E0 <= (h/2) / (1 - h/2), h = omega dt.
  for (const TableRow& row : read_rows("E7_symplectic_euler_energy_band.csv")) {
    const double h = row("omega*dt");
    const double bound = row("max relative energy error bound (h/2)/(1-h/2) (exact invariant: v^2+w^2x^2 - h w x v)");
    double worst = 0.0;
    follow_energy("symplectic_euler", h, 2000, [&](int, double e) { worst = std::max(worst, std::abs(e - 1.0)); });
    EXPECT_LE(worst, bound * (1.0 + 1e-12)) << h;
    EXPECT_GE(worst, 0.9 * bound) << h;  // and the bound is reached
  }
}

TEST(SymplecticSchemes, LetTheEnergyWaverButNotDrift) {
  // Least-squares slope of E / E0 over a million steps below 1e-12 a step. The weights vanish at both ends, so that the
  // periods begun and not ended there do not count.
  for (const std::string scheme : {"symplectic_euler", "velocity_verlet"}) {
    const int steps = 1000000;
    double sum = 0.0, moment = 0.0;
    follow_energy(scheme, 0.1, steps, [&](int k, double e) {
      const double t = k - 0.5 * (steps - 1);
      const double weight = 1.0 - 4.0 * t * t / (static_cast<double>(steps) * steps);
      sum += weight * t * t;
      moment += weight * t * (e - 1.0);
    });
    check("E4", scheme + ", drift of the energy per step", moment / sum, 0.0, 1e-12, Tolerance::kAbsolute);
  }
}

TEST(ImplicitMidpoint, KeepsTheEnergyOfALinearBody) {
  double worst = 0.0;
  follow_energy("implicit_midpoint", 3.0, 2000, [&](int, double e) { worst = std::max(worst, std::abs(e - 1.0)); });
  check("E4", "implicit_midpoint, energy error of an oscillator at omega dt = 3", worst, 0.0, 1e-11,
        Tolerance::kAbsolute);
}

class SchemeMomentum : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, SchemeMomentum, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(SchemeMomentum, KeepsTheMomentaItClaims) {
  // Internal forces come in opposite pairs along their line. Every scheme keeps the linear momentum; the symplectic
  // ones and the midpoint rule keep the angular one as well, since they conserve quadratic invariants.
  const TriangleMesh mesh = make_grid(0.5, 0.4, 4, 3);
  SheetStiffness stiffness;
  stiffness.membrane = 50.0;
  stiffness.damping_time = 1e-3;
  System sheet(mesh.rest, sheet_masses(mesh, 0.15));
  sheet.add_springs(sheet_network(mesh, stiffness));
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  sheet.state.v = Nodes::NullaryExpr(3, mesh.rest.cols(), [&] { return normal(generator); });
  const auto linear = [&] { return Vec3(sheet.state.v * sheet.mass); };
  const auto angular = [&] {
    Vec3 sum = Vec3::Zero();
    for (Eigen::Index i = 0; i < sheet.mass.size(); ++i) {
      sum += sheet.mass[i] * Vec3(sheet.state.x.col(i)).cross(Vec3(sheet.state.v.col(i)));
    }
    return sum;
  };
  const Vec3 linear_start = linear(), angular_start = angular();
  const auto integrator = make_integrator(GetParam(), exact_settings(1e-12));
  for (int k = 0; k < 100; ++k) sheet.step(*integrator, 2e-4);
  check("E4", GetParam() + ", change of momentum, N s", (linear() - linear_start).norm(), 0.0, 1e-12,
        Tolerance::kAbsolute);
  const bool conserves =
      GetParam() == "symplectic_euler" || GetParam() == "velocity_verlet" || GetParam() == "implicit_midpoint";
  const double change = (angular() - angular_start).norm();
  if (conserves)
    check("E4", GetParam() + ", change of angular momentum, N m s", change, 0.0, 1e-12, Tolerance::kAbsolute);
}

}  // namespace
}  // namespace deformable_sim::test
