// A consistent mass matrix under every scheme.
#include <gtest/gtest.h>

#include <cmath>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

constexpr int kElements = 8;
constexpr double kStiffness = 50.0, kMass = 0.2;  // of an element, N/m and kg

/// A free bar of linear elements along x: K = k [1 -1; -1 1], M = m / 6 [2 1; 1 2] each.
class Bar : public System {
 public:
  Bar() : System(make_line(1.0, kElements).rest, lumped()), mass_matrix_(kElements + 1, kElements + 1) {
    std::vector<SpringLink> links;
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < kElements; ++i) {
      links.push_back({i, i + 1, 1.0 / kElements, kStiffness, 0.0});
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b) entries.emplace_back(i + a, i + b, kMass / (a == b ? 3.0 : 6.0));
    }
    mass_matrix_.setFromTriplets(entries.begin(), entries.end());
    dynamics.mass_matrix = &mass_matrix_;
    add(make_springs("springs", links, 0));
  }
  /// omega^2 = 6 k / m (1 - cos q) / (2 + cos q), q = mode pi / n; the shape is cos(q i).
  static double frequency(int mode) {
    const double c = std::cos(M_PI * mode / kElements);
    return std::sqrt(6.0 * kStiffness / kMass * (1.0 - c) / (2.0 + c));
  }
  static Nodes shape(int mode) {
    Nodes u = Nodes::Zero(3, kElements + 1);
    for (int i = 0; i <= kElements; ++i) u(0, i) = std::cos(M_PI * mode * i / kElements);
    return u;
  }

 private:
  static Eigen::VectorXd lumped() {
    Eigen::VectorXd mass = Eigen::VectorXd::Constant(kElements + 1, kMass);
    mass[0] = mass[kElements] = 0.5 * kMass;
    return mass;
  }
  Eigen::SparseMatrix<double> mass_matrix_;
};

TEST(MassMatrix, GivesTheHighestFrequencyOfTheConsistentBar) {
  // omega_max^2 = 12 k / m, three times that of lumped masses.
  Bar bar;
  EXPECT_NEAR(highest_frequency(bar.dynamics, bar.state), std::sqrt(12.0 * kStiffness / kMass), 1e-3 * 54.8);
  bar.dynamics.mass_matrix = nullptr;
  EXPECT_NEAR(highest_frequency(bar.dynamics, bar.state), std::sqrt(4.0 * kStiffness / kMass), 1e-3 * 31.6);
}

std::vector<std::string> names_with_mass_matrix() {
  std::vector<std::string> names;
  for (const std::string& name : integrator_names()) {
    if (!make_integrator(name, {})->needs().lumped_mass) names.push_back(name);
  }
  return names;
}

class MassMatrix : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, MassMatrix, testing::ValuesIn(names_with_mass_matrix()),
                         [](const auto& info) { return info.param; });

TEST_P(MassMatrix, SwingsABarWithItsConsistentFrequency) {
  // u(t) = U cos(omega t): back where it was after a period, in N steps. First order: the amplitude changes by
  // pi^2/N... of itself, second order: the phase by some (2 pi)^3 / (4 N^2).
  const int mode = 3, steps = 1000;
  Bar bar;
  const double amplitude = 1e-3;
  bar.state.x += amplitude * Bar::shape(mode);
  const auto integrator = make_integrator(GetParam(), exact_settings(1e-9));
  for (int k = 0; k < steps; ++k) bar.step(*integrator, 2.0 * M_PI / Bar::frequency(mode) / steps);
  const double tolerance = integrator->order() == 1 ? 2.5 * M_PI * M_PI / steps : 70.0 / (steps * steps);
  const Nodes expected = make_line(1.0, kElements).rest + amplitude * Bar::shape(mode);
  EXPECT_LT((bar.state.x - expected).cwiseAbs().maxCoeff(), tolerance * amplitude);
}

TEST_P(MassMatrix, BalancesTheHoldersForceWithMomentum) {
  // The holder of one end feels the inertia that the matrix couples to it: impulse = change of 1^T M v.
  Bar bar;
  bar.hold(0);
  const auto integrator = make_integrator(GetParam(), exact_settings(1e-9));
  const double dt = 1e-3;
  const Nodes start = bar.state.x;
  double impulse = 0.0;
  for (int k = 1; k <= 200; ++k) {
    bar.dynamics.kinematics.target(0, 0) = start(0, 0) + 0.01 * (1.0 - std::cos(10.0 * k * dt));
    bar.step(*integrator, dt);
    impulse += dt * bar.dynamics.kinematics.reaction(0, 0);
  }
  const double momentum = (bar.state.v * *bar.dynamics.mass_matrix).row(0).sum();
  EXPECT_GT(momentum, 0.01);
  EXPECT_NEAR(impulse, momentum, GetParam() == "bdf2" ? 2e-3 : 1e-9);
}

TEST_P(MassMatrix, OfLumpedMassesChangesNothing) {
  Bar bar, other;
  Eigen::SparseMatrix<double> diagonal(kElements + 1, kElements + 1);
  for (int i = 0; i <= kElements; ++i) diagonal.insert(i, i) = bar.mass[i];
  bar.dynamics.mass_matrix = &diagonal;
  other.dynamics.mass_matrix = nullptr;
  const auto a = make_integrator(GetParam(), exact_settings(1e-10)),
             b = make_integrator(GetParam(), exact_settings(1e-10));
  for (System* body : {static_cast<System*>(&bar), static_cast<System*>(&other)}) {
    body->add_gravity().hold(0);
    body->state.x(1, 4) += 0.01;
  }
  for (int k = 0; k < 50; ++k) {
    bar.step(*a, 1e-3);
    other.step(*b, 1e-3);
  }
  EXPECT_LT((bar.state.x - other.state.x).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((bar.dynamics.kinematics.reaction - other.dynamics.kinematics.reaction).norm(), 1e-7);
}

}  // namespace
}  // namespace deformable_sim::test
