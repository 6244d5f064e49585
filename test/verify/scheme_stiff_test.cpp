// E8: classical stiff problems as forces on one node, and a chain of stiff and soft springs over a long time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/point_force.h"
#include "support/slope.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// The implicit schemes, but for one.
std::vector<std::string> implicit_names(const std::string& without) {
  std::vector<std::string> names;
  for (const std::string& name : integrator_names())
    if (make_integrator(name, {})->needs().jacobian && name != without) names.push_back(name);
  return names;
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}

// Linearised with a symmetric matrix, this unsymmetric reaction is another one.
class Robertson : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, Robertson, testing::ValuesIn(implicit_names("linear_implicit_euler")), name_of);

// The midpoint rule, which does not damp the stiff, rings after the jump.
class VanDerPol : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, VanDerPol, testing::ValuesIn(implicit_names("implicit_midpoint")), name_of);

class ProtheroRobinson : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, ProtheroRobinson, testing::ValuesIn(implicit_names("")), name_of);

TableRow stiff_row(const std::string& problem, double time) {
  for (const TableRow& row : read_rows("E5_stiff_ode_end_values.csv"))
    if (row.text("problem") == problem && row("t_end") == time) return row;
  ADD_FAILURE() << problem;
  return {{}, {}};
}

/// Robertson's reaction as a velocity: v = (y1, y2, y3). The matrix has the diagonal of its Jacobian alone, which is
/// what a symmetric solver can take of it; Newton's method then converges all the same.
std::unique_ptr<Energy> robertson() {
  return std::make_unique<PointForce>(
      [](const Vec3&, const Vec3& y, double) {
        const double slow = 0.04 * y[0] - 1e4 * y[1] * y[2], fast = 3e7 * y[1] * y[1];
        return Vec3(-slow, slow - fast, fast);
      },
      [](const Vec3&, const Vec3& y, double) {
        const Mat3 by_y = Vec3(-0.04, -1e4 * y[2] - 6e7 * y[1], 0.0).asDiagonal();
        return std::pair<Mat3, Mat3>(Mat3::Zero(), by_y);
      });
}

TEST_P(Robertson, IsFollowedToItsEnd) {
  // y(40) = (0.71582706871941, 9.1855347645579e-06, 0.28416374574583), rates from 0.04 to 3e7; steps of 20 ms are a
  // hundred times longer than what decays. First order: some 1e-4; second order: below 1e-6.
  System body(Nodes::Zero(3, 1), Eigen::VectorXd::Ones(1));
  body.state.v.col(0) = Vec3(1, 0, 0);
  body.add(robertson());
  const auto integrator = make_integrator(GetParam(), exact_settings(1e-10));
  // The first hundredth of a second, in which y2 is filled, in short steps that grow.
  double dt = 1e-5;
  while (body.state.time < 40.0 - 1e-9) {
    const double step = std::min(dt, 40.0 - body.state.time);
    body.step(*integrator, step);
    dt = std::min(0.02, 1.02 * dt);
  }
  const TableRow exact = stiff_row("Robertson", 40.0);
  const double tolerance = make_integrator(GetParam(), {})->order() == 1 ? 2e-4 : 1e-6;
  check("E8", GetParam() + ", Robertson y1(40)", body.state.v(0, 0), exact("y1"), tolerance);
  check("E8", GetParam() + ", Robertson y2(40)", body.state.v(1, 0), exact("y2"), 2.0 * tolerance);
  check("E8", GetParam() + ", Robertson y3(40)", body.state.v(2, 0), exact("y3"), 3.0 * tolerance);
}

TEST_P(VanDerPol, IsFollowedThroughItsJumps) {
  // x'' = ((1 - x^2) x' - x) / eps, eps = 1e-6, from (2, -0.66): x(2) = 1.7061677, x'(2) = -0.8928097. It creeps, and
  // jumps within microseconds, where accelerations are 1e12 and known to 0.1. Steps cover 2e-3 of the way, at most 1 ms
  // and at most twice the last.
  const double eps = 1e-6;
  System body(Vec3(2, 0, 0), Eigen::VectorXd::Ones(1));
  body.state.v(0, 0) = -0.66;
  body.add(std::make_unique<PointForce>(
      [=](const Vec3& x, const Vec3& v, double) { return Vec3(((1.0 - x[0] * x[0]) * v[0] - x[0]) / eps, 0, 0); },
      [=](const Vec3& x, const Vec3& v, double) {
        const Mat3 by_x = Vec3(-(2.0 * x[0] * v[0] + 1.0) / eps, 0, 0).asDiagonal();
        const Mat3 by_v = Vec3((1.0 - x[0] * x[0]) / eps, 0, 0).asDiagonal();
        return std::pair<Mat3, Mat3>(by_x, by_v);
      }));
  const auto integrator = make_integrator(GetParam(), exact_settings(1.0));
  double dt = 1e-7;
  long steps = 0;
  while (body.state.time < 2.0 - 1e-12 && ++steps < 200000) {
    body.step(*integrator, std::min(dt, 2.0 - body.state.time));
    dt = std::min({1.9 * dt, 1e-3, 2e-3 / std::abs(body.state.v(0, 0))});
  }
  const TableRow exact = stiff_row("VanDerPol eps=1e-6", 2.0);
  // Steps of 2e-3 make errors of that to the power of the order, times some ten.
  const double tolerance = make_integrator(GetParam(), {})->order() == 1 ? 1e-2 : 2e-4;
  check("E8", GetParam() + ", van der Pol x(2)", body.state.x(0, 0), exact("y1"), tolerance);
  check("E8", GetParam() + ", van der Pol x'(2)", body.state.v(0, 0), exact("y2"), tolerance);
}

TEST_P(ProtheroRobinson, CostsNoOrder) {
  // v' = lambda (v - cos t) - sin t, lambda = -1e6, v = cos t: steps a million times longer than the relaxation.
  const double lambda = -1e6;
  std::vector<double> steps, errors;
  for (int count = 10; count <= 160; count *= 2) {
    System body(Nodes::Zero(3, 1), Eigen::VectorXd::Ones(1));
    body.state.v(0, 0) = 1.0;
    body.add(std::make_unique<PointForce>(
        [=](const Vec3&, const Vec3& v, double t) { return Vec3(lambda * (v[0] - std::cos(t)) - std::sin(t), 0, 0); },
        [=](const Vec3&, const Vec3&, double) {
          return std::pair<Mat3, Mat3>(Mat3::Zero(), Mat3(Vec3(lambda, 0, 0).asDiagonal()));
        }));
    const auto integrator = make_integrator(GetParam(), exact_settings(1e-9));
    for (int k = 0; k < count; ++k) body.step(*integrator, 1.0 / count);
    steps.push_back(1.0 / count);
    errors.push_back(std::abs(body.state.v(0, 0) - std::cos(1.0)));
  }
  const double order = make_integrator(GetParam(), {})->order();
  EXPECT_GE(log_slope(steps, errors), order - 0.1);
}

/// Six unit masses on a line between walls, every other spring stiff and linear, the rest soft and cubic:
///   E = 1/2 sum v^2 + omega^2 / 4 sum (q_2i - q_2i-1)^2 + sum (q_2i+1 - q_2i)^4 [Hairer 2006, I.5.1].
class StiffChain : public Energy {
 public:
  static constexpr double kOmega = 50.0;
  std::string name() const override { return "stiff and soft springs"; }
  int element_count() const override { return 7; }
  double value(const State&) const override { return 0.0; }
  void add_force(const State& s, Nodes* f) const override {
    const auto q = [&](Eigen::Index k) { return k < 0 || k > 5 ? 0.0 : s.x(0, k); };
    for (Eigen::Index k = -1; k < 6; ++k) {  // between q_k and q_k+1
      const double stretch = q(k + 1) - q(k);
      const double pull = k % 2 == 0 ? 0.5 * kOmega * kOmega * stretch : 4.0 * stretch * stretch * stretch;
      if (k >= 0) (*f)(0, k) += pull;
      if (k < 5) (*f)(0, k + 1) -= pull;
    }
  }
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override {
    for (int k = 0; k < 5; ++k) pairs->push_back({k, k + 1});
  }
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State& s, double dx, double, Jacobian, BlockMatrix* a) const override {
    const auto q = [&](int k) { return k < 0 || k > 5 ? 0.0 : s.x(0, k); };
    for (int k = -1; k < 6; ++k) {
      const double stretch = q(k + 1) - q(k);
      const double slope = dx * (k % 2 == 0 ? 0.5 * kOmega * kOmega : 12.0 * stretch * stretch);
      if (k >= 0) a->block(a->slot(k, k))(0, 0) += slope;
      if (k < 5) a->block(a->slot(k + 1, k + 1))(0, 0) += slope;
      if (k < 0 || k > 4) continue;
      a->block(a->slot(k, k + 1))(0, 0) -= slope;
      a->block(a->slot(k + 1, k))(0, 0) -= slope;
    }
  }
};

/// The energies of the three stiff springs: I_j = 1/2 (y'^2 + omega^2 y^2), y = (q_2j - q_2j-1) / sqrt(2).
Vec3 stiff_energies(const State& s) {
  Vec3 energy;
  for (int j = 0; j < 3; ++j) {
    const double y = (s.x(0, 2 * j + 1) - s.x(0, 2 * j)) / std::sqrt(2.0);
    const double speed = (s.v(0, 2 * j + 1) - s.v(0, 2 * j)) / std::sqrt(2.0);
    energy[j] = 0.5 * (speed * speed + StiffChain::kOmega * StiffChain::kOmega * y * y);
  }
  return energy;
}

std::unique_ptr<System> stiff_chain() {
  auto chain = std::make_unique<System>(Nodes::Zero(3, 6), Eigen::VectorXd::Ones(6));
  chain->add(std::make_unique<StiffChain>());
  // One slow coordinate and the first stiff spring excited: (q1 + q2) / sqrt(2) = 1, (q2 - q1) / sqrt(2) = 1 / omega.
  const double half = std::sqrt(0.5), fast = half / StiffChain::kOmega;
  chain->state.x(0, 0) = half - fast;
  chain->state.x(0, 1) = half + fast;
  chain->state.v(0, 0) = 0.0;
  chain->state.v(0, 1) = 2.0 * half;
  return chain;
}

class LongRun : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Symplectic, LongRun, testing::Values("symplectic_euler", "velocity_verlet"), name_of);

TEST_P(LongRun, KeepsTheStiffEnergyWhileTheSpringsExchangeIt) {
  // I1 + I2 + I3 = 1 within 3 % to t = 200, while energy wanders from the first stiff spring to the third [ibid.].
  // Means over 1 s: from instant to instant the exact solution itself wavers by 1.4 % RMS and 6.6 % at most.
  auto chain = stiff_chain();
  const auto integrator = make_integrator(GetParam(), {});
  const double dt = 1e-3;
  double worst = 0.0, first_least = 1.0, third_most = 0.0;
  for (int second = 0; second < 200; ++second) {
    Vec3 mean = Vec3::Zero();
    for (int k = 0; k < 1000; ++k) {
      chain->step(*integrator, dt);
      mean += 1e-3 * stiff_energies(chain->state);
    }
    worst = std::max(worst, std::abs(mean.sum() - 1.0));
    first_least = std::min(first_least, mean[0]);
    third_most = std::max(third_most, mean[2]);
  }
  check("E8", GetParam() + ", stiff energy, largest departure from 1 to t = 200", worst, 0.0, 0.03,
        Tolerance::kAbsolute);
  EXPECT_LT(first_least, 0.1);
  EXPECT_GT(third_most, 0.9);
}

TEST(LongRun, HasTheTabulatedExchangeWithRungeKutta) {
  // I3(150) = 0.95277.
  auto chain = stiff_chain();
  const auto integrator = make_integrator("rk4", {});
  const double dt = 1e-3;
  for (long k = 0; k < 150000; ++k) chain->step(*integrator, dt);
  check("E8", "rk4, stiff energy of the third spring at t = 150", stiff_energies(chain->state)[2], 0.95277, 1e-3);
}

TEST(LongRun, LosesTheStiffEnergyUnderImplicitEuler) {
  // A factor 1 / (1 + (omega dt)^2) a step: nothing is left after t = 2 at omega dt = 0.5 but what the soft springs,
  // whose forces are of the order of 1, press the stiff ones together: 1 / omega^2.
  auto chain = stiff_chain();
  const auto integrator = make_integrator("implicit_euler", exact_settings(1e-8));
  for (int k = 0; k < 200; ++k) chain->step(*integrator, 0.01);
  EXPECT_LT(stiff_energies(chain->state).sum(), 10.0 / (StiffChain::kOmega * StiffChain::kOmega));
}

}  // namespace
}  // namespace deformable_sim::test
