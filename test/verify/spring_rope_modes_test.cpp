// Small motions of ropes of springs: hanging chain, taut string, waves along a chain, pendulum.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/linear_response.h"
#include "support/slope.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// N equal bobs on N links, total length and weight 1; rest lengths such that every loaded link is 1 / N long.
std::unique_ptr<System> hanging_chain(int n) {
  const double m = 1.0 / (n * kGravity), k = 100.0;
  Nodes x = Nodes::Zero(3, n + 1);
  std::vector<SpringLink> links;
  for (int i = 0; i < n; ++i) {
    x(2, i + 1) = -(i + 1.0) / n;
    links.push_back({i, i + 1, 1.0 / n - (n - i) * m * kGravity / k, k, 0.0});
  }
  auto chain = std::make_unique<System>(x, Eigen::VectorXd::Constant(n + 1, m));
  chain->add(make_springs("springs", links, 0)).add_gravity().hold(0);
  return chain;
}

TEST(HangingChain, SwingsWithTheZerosOfLaguerre) {
  // omega^2 = (g N / L) times the zeros of L_N, exactly: transverse stiffness is tension over length, whatever k.
  for (const TableRow& row : read_rows("B4_hanging_chain_modes.csv")) {
    if (row.text("N_links_equal_bobs").find("continuum") != std::string::npos) continue;
    const int n = static_cast<int>(row("N_links_equal_bobs"));
    auto chain = hanging_chain(n);
    EXPECT_LT(chain->forces().rightCols(n).norm(), 1e-12);  // at rest
    const Eigen::VectorXd omega = natural_frequencies(chain.get(), coordinates(1, n, {0})) / std::sqrt(kGravity);
    const std::string name = "chain of " + std::to_string(n) + " links, omega sqrt(L/g), mode ";
    const char* columns[] = {"w1*sqrt(L/g)", "w2", "w3", "w4", "w5"};
    for (int mode = 0; mode < std::min(n, 5); ++mode) {
      if (row.text(columns[mode]).empty()) continue;
      check("B4", name + std::to_string(mode + 1), omega[mode], row(columns[mode]), 1e-8);
    }
    check("B4", name + "last", omega[n - 1], row("w_max"), 1e-8);
  }
}

TEST(HangingChain, TendsToTheZerosOfBessel) {
  // omega_n = (j_0n / 2) sqrt(g / L), first order in 1 / N; the limit of N = 20, 40, 80 within 0.5 %.
  const double bessel[] = {1.20241277885, 2.76003905514, 4.32686395646};
  std::vector<Eigen::VectorXd> omega;
  for (const int n : {20, 40, 80}) {
    auto chain = hanging_chain(n);
    omega.push_back(natural_frequencies(chain.get(), coordinates(1, n, {1})) / std::sqrt(kGravity));
  }
  for (int mode = 0; mode < 3; ++mode) {
    const std::string name = "hanging chain, mode " + std::to_string(mode + 1);
    check("B4", name + ", limit of omega sqrt(L/g)", 2.0 * omega[2][mode] - omega[1][mode], bessel[mode], 0.005);
    check("B4", name + ", order", std::log2((omega[1][mode] - bessel[mode]) / (omega[2][mode] - bessel[mode])), 1.0,
          0.1, Tolerance::kAbsolute);
  }
}

/// N beads on a string of unit length, tension and line density between fixed ends.
std::unique_ptr<System> taut_string(int n, double stiffness) {
  const double a = 1.0 / (n + 1);
  Nodes x = Nodes::Zero(3, n + 2);
  std::vector<SpringLink> links;
  for (int i = 0; i < n + 2; ++i) x(0, i) = a * i;
  for (int i = 0; i <= n; ++i) links.push_back({i, i + 1, a - 1.0 / stiffness, stiffness, 0.0});
  auto string = std::make_unique<System>(x, Eigen::VectorXd::Constant(n + 2, a));
  string->add(make_springs("springs", links, 0)).hold(0).hold(n + 1);
  return string;
}

TEST(TautString, HasTheFrequenciesOfItsBeads) {
  // omega_n = 2 sqrt(T / (m a)) sin(n pi / (2 (N + 1))), exactly.
  for (const TableRow& row : read_rows("B5_taut_string_modes.csv")) {
    const int n = static_cast<int>(row("N_interior_beads")), mode = static_cast<int>(row("mode"));
    auto string = taut_string(n, 20.0 * (n + 1));
    const Eigen::VectorXd omega = natural_frequencies(string.get(), coordinates(1, n, {2}));
    check("B5", "string of " + std::to_string(n) + " beads, omega L / c, mode " + std::to_string(mode), omega[mode - 1],
          row("omega*L/c_discrete"), 1e-8);
  }
}

TEST(TautString, SwingsAtThatFrequency) {
  // The first mode of 9 beads, amplitude 1e-4: the added tension changes omega by (EA / T) (pi amplitude)^2 3 / 32 <
  // 1e-6; the phase of Runge-Kutta is off by (omega dt)^4 / 120.
  const int n = 9;
  auto string = taut_string(n, 5.0 * (n + 1));
  for (int i = 1; i <= n; ++i) string->state.x(2, i) = 1e-4 * std::sin(M_PI * i / (n + 1.0));
  const auto integrator = make_integrator("rk4", {});
  const double dt = 2e-3;
  std::vector<double> passages;
  while (passages.size() < 7) {
    const double before = string->state.x(2, 5);
    string->step(*integrator, dt);
    const double after = string->state.x(2, 5);
    if (before * after < 0.0) passages.push_back(string->state.time - after / string->state.v(2, 5));
  }
  check("B5", "string of 9 beads, omega L / c from three periods", 3.0 * 2.0 * M_PI / (passages[6] - passages[0]),
        2.0 * 10.0 * std::sin(M_PI / 20.0), 1e-6);
}

TEST(ChainWaves, HaveTheDispersionOfALattice) {
  // omega = 2 sqrt(k / m) |sin(q a / 2)|: one wavelength of a chain, its stiffness taken from the assembled matrix.
  const int n = 4;
  const Polyline line = make_line(n, n);
  LineStiffness stiffness;
  stiffness.stretch = 1.0;
  stiffness.bend = 0.0;
  System chain(line.rest, Eigen::VectorXd::Ones(n + 1));
  chain.add_springs(line_network(line, stiffness));
  const Eigen::MatrixXd k = stiffness_matrix(&chain);
  for (const TableRow& row : read_rows("B6_spring_chain_dispersion.csv")) {
    const double qa = row("qa");
    const double square = k(6, 6) + (k(6, 3) + k(6, 9)) * std::cos(qa);
    check("B6", "axial wave, q a = " + row.text("qa") + ", omega sqrt(m/k)", std::sqrt(square), row("omega*sqrt(m/k)"),
          1e-8);
  }
}

TEST(ChainWaves, CarryAPulseAtTheSpeedOfTheRope) {
  // c = a sqrt(k/m) = sqrt(EA / mu) within 0.5 % at q a < 0.3: a Gauss pulse of 12 springs' half width.
  const int n = 300;
  const double a = 0.01, axial = 40.0, density = 0.1, c = std::sqrt(axial / density);
  const Polyline line = make_line(n * a, n);
  LineStiffness stiffness;
  stiffness.axial = axial;
  stiffness.bend = 0.0;
  System rope(line.rest, line_masses(line, density));
  rope.add_springs(line_network(line, stiffness));
  const double start = line.rest(0, 80), width = 12.0 * a, height = 1e-5;
  for (int i = 0; i <= n; ++i) {  // moving to the right: v = -c du/dx
    const double s = (line.rest(0, i) - start) / width, u = height * std::exp(-0.5 * s * s);
    rope.state.x(0, i) += u;
    rope.state.v(0, i) = c * s / width * u;
  }
  const auto integrator = make_integrator("rk4", {});
  const double dt = 0.2 * a / c;
  const int steps = 750;
  for (int k = 0; k < steps; ++k) rope.step(*integrator, dt);
  double weight = 0.0, place = 0.0;  // centre of the pulse
  for (int i = 0; i <= n; ++i) {
    const double u = rope.state.x(0, i) - line.rest(0, i);
    weight += u * u;
    place += u * u * line.rest(0, i);
  }
  check("B6", "speed of an axial pulse, m/s", (place / weight - start) / (steps * dt), c, 0.005);
}

TEST(ElasticPendulum, HasTheTwoModesOfItsEquilibrium) {
  // omega = sqrt(k / m) along the spring, sqrt(g / l) across it, l = l0 + m g / k.
  for (const TableRow& row : read_rows("B17_elastic_pendulum_modes.csv")) {
    const double ratio = row("mg/(k l0)"), m = 0.7, l0 = 0.4, k = m * kGravity / (ratio * l0);
    Nodes x = Nodes::Zero(3, 2);
    x(2, 1) = -l0 * (1.0 + ratio);
    System pendulum(x, Eigen::Vector2d(1.0, m));
    pendulum.add(make_springs("spring", {{0, 1, l0, k, 0.0}}, 0)).add_gravity().hold(0);
    const double unit = std::sqrt(l0 / kGravity);
    const std::string name = "elastic pendulum, m g / (k l0) = " + row.text("mg/(k l0)");
    check("B17", name + ", swing, omega sqrt(l0/g)", natural_frequencies(&pendulum, {3})[0] * unit,
          row("omega_swing*sqrt(l0/g)"), 1e-8);
    check("B17", name + ", spring, omega sqrt(l0/g)", natural_frequencies(&pendulum, {5})[0] * unit,
          row("omega_spring*sqrt(l0/g)"), 1e-8);
  }
}

/// Full period of a pendulum of 1 m, 1 kg on a spring, from two passages through the vertical.
double pendulum_period(double degrees, double stiffness) {
  const double angle = degrees * M_PI / 180.0, dt = 0.1 / std::sqrt(stiffness);
  System system((Nodes(3, 2) << 0, std::sin(angle), 0, 0, 0, -std::cos(angle)).finished(), Eigen::Vector2d(1, 1));
  // Starts with the elongation of its tension, so that what is set off along the spring is of order 1/k^2. Damping it
  // would cost energy of order k^-1.5 and hide the order.
  system.add(make_springs("rod", {{0, 1, 1.0, stiffness, 0.0}}, 0)).add_gravity().hold(0);
  system.state.x.col(1) *= 1.0 + kGravity * std::cos(angle) / stiffness;
  const auto integrator = make_integrator("rk4", {});
  std::vector<double> passages;
  while (passages.size() < 2 && system.state.time < 10.0) {
    const double before = system.state.x(0, 1);
    system.step(*integrator, dt);
    const double after = system.state.x(0, 1);
    if (before * after < 0.0) passages.push_back(system.state.time - after / system.state.v(0, 1));
  }
  return passages.size() < 2 ? 0.0 : 2.0 * (passages[1] - passages[0]);
}

TEST(SpringPendulum, TendsToThePeriodOfTheEllipticIntegral) {
  // T / T0 = 2 K(sin(theta / 2)) / pi; first order in 1 / k.
  const double small = 2.0 * M_PI / std::sqrt(kGravity);
  for (const TableRow& row : read_rows("B7_pendulum_period_ratio.csv")) {
    const double degrees = row("theta0_deg");
    if (degrees != 10.0 && degrees != 90.0 && degrees != 150.0 && !verify_all()) continue;
    if (degrees > 175.0) continue;  // balances on its head: the elongation of the rod decides
    const double a = pendulum_period(degrees, 2e5) / small, b = pendulum_period(degrees, 4e5) / small,
                 c = pendulum_period(degrees, 8e5) / small, expected = row("T/(2 pi sqrt(L/g))");
    const std::string name = "pendulum from " + row.text("theta0_deg") + " degrees";
    check("B7", name + ", T / T0 in the limit of 1/k", (8.0 * c - 6.0 * b + a) / 3.0, expected, 1e-8);
    check("B7", name + ", order in 1/k", std::log2((a - b) / (b - c)), 1.0, 0.01, Tolerance::kAbsolute);
  }
}

}  // namespace
}  // namespace deformable_sim::test
