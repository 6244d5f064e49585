// E1, E2: step limits and amplification of every scheme on the damped oscillator, from the matrix of one step.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/point_force.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

/// The tables' names. The linearised scheme is implicit Euler where forces are linear.
const std::map<std::string, std::string> kTableName = {
    {"explicit_euler", "explicit_euler"},
    {"symplectic_euler", "symplectic_euler (damping explicit)"},
    {"velocity_verlet", "velocity_verlet (damping lagged)"},
    {"rk4", "RK4"},
    {"implicit_euler", "implicit_euler"},
    {"linear_implicit_euler", "implicit_euler"},
    {"implicit_midpoint", "implicit_midpoint/trapezoid/Newmark(1/4,1/2)"},
    {"bdf2", "BDF2"},
    {"tr_bdf2", "TR-BDF2"}};

/// Spectral radius of one step: lim |A^n|^(1/n), n = 2^50 by repeated squaring.
double amplification(const std::string& scheme, double zeta, double dt) {
  Eigen::Matrix4d power = step_matrix(scheme, zeta, dt);
  double log_radius = 0.0;
  for (double share = 1.0; share > 1e-15; share *= 0.5) {
    const double norm = power.norm();
    if (norm == 0.0) return 0.0;
    log_radius += share * std::log(norm);
    power = Eigen::Matrix4d((power / norm) * (power / norm));
  }
  return std::exp(log_radius);
}

/// Angle by which one step of a scheme that remembers nothing turns an undamped oscillator.
double turn(const std::string& scheme, double dt) {
  const Eigen::Matrix2d step = step_matrix(scheme, 0.0, dt).topLeftCorner<2, 2>();
  return std::acos(0.5 * step.trace() / std::sqrt(step.determinant()));
}

class SchemeLimit : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, SchemeLimit, testing::ValuesIn(one_step_names()),
                         [](const auto& info) { return info.param; });

TEST_P(SchemeLimit, IsStableUpToTheTabulatedStepAndNotBeyond) {
  // The largest omega dt at which no eigenvalue of the step exceeds 1.
  ASSERT_TRUE(kTableName.count(GetParam())) << "name this scheme in the tables";
  int rows = 0;
  for (const TableRow& row : read_rows("E1_stability_limits.csv")) {
    if (row.text("method") != kTableName.at(GetParam())) continue;
    ++rows;
    const double zeta = row("zeta"), limit = row("max omega*dt (numerical spectral radius)");
    SCOPED_TRACE("zeta " + row.text("zeta"));
    const auto grows = [&](double dt) { return amplification(GetParam(), zeta, dt) > 1.0 + 1e-7; };
    const double claimed = make_integrator(GetParam(), {})->stability_limit(zeta);
    if (std::isinf(limit)) {
      EXPECT_TRUE(std::isinf(claimed));
      for (const double dt : {0.01, 0.1, 1.0, 10.0, 100.0, 1e4}) EXPECT_FALSE(grows(dt)) << dt;
      continue;
    }
    EXPECT_NEAR(claimed, limit, 1e-7);  // the table found a double eigenvalue numerically
    if (limit == 0.0) {
      for (const double dt : {1e-3, 0.1, 1.0}) EXPECT_TRUE(grows(dt)) << dt;
      continue;
    }
    double below = 0.0, above = limit / 200.0;
    while (above < 1.1 * limit && !grows(above)) {
      below = above;
      above += limit / 200.0;
    }
    for (int k = 0; k < 30; ++k) (grows(0.5 * (below + above)) ? above : below) = 0.5 * (below + above);
    check("E1", GetParam() + ", largest omega dt at damping ratio " + row.text("zeta"), below, limit, 1e-3);
  }
  EXPECT_EQ(rows, 8);
}

TEST_P(SchemeLimit, AmplifiesPerStepAsTabulated) {
  // |R| of an undamped oscillator. Where two eigenvalues meet (omega dt = 2 of the symplectic schemes) powers of the
  // step grow like n, and their rounding with them.
  for (const TableRow& row : read_rows("E2_amplification_per_step_undamped.csv")) {
    const double dt = row("omega*dt"), expected = row(kTableName.at(GetParam()) + " |R|");
    const bool meet = dt == 2.0 && make_integrator(GetParam(), {})->stability_limit() == 2.0;
    check("E2", GetParam() + ", |R| at omega dt " + row.text("omega*dt"), amplification(GetParam(), 0.0, dt), expected,
          meet ? 1e-5 : 1e-10);
  }
}

TEST_P(SchemeLimit, DampsTheStiffLimitAsItClaims) {
  // |R(infinity)|: 0 for implicit Euler, BDF2 (like (3/4)^(1/2) z^(-1/2)) and TR-BDF2, 1 for the midpoint rule.
  if (!std::isinf(make_integrator(GetParam(), {})->stability_limit())) return;
  const double expected = GetParam() == "implicit_midpoint" ? 1.0 : 0.0;
  check("E8", GetParam() + ", |R(infinity)|", amplification(GetParam(), 0.0, 1e8), expected, 1e-4,
        Tolerance::kAbsolute);
}

TEST(ImplicitSchemes, TurnWithTheFrequencyOfTheory) {
  // Phase per step: atan(omega dt) for implicit Euler, 2 atan(omega dt / 2) for the midpoint rule.
  for (const TableRow& row : read_rows("E2_amplification_per_step_undamped.csv")) {
    const double dt = row("omega*dt");
    if (dt < 0.01 || dt > 2.0) continue;  // the cosine of a small angle does not know it to ten digits
    check("E2", "implicit_euler, frequency ratio at omega dt " + row.text("omega*dt"), turn("implicit_euler", dt) / dt,
          row("implicit Euler frequency ratio atan(h)/h"), 1e-10);
    check("E2", "implicit_midpoint, frequency ratio at omega dt " + row.text("omega*dt"),
          turn("implicit_midpoint", dt) / dt, row("implicit midpoint frequency ratio 2 atan(h/2)/h"), 1e-10);
  }
}

TEST(ImplicitEuler, LeavesTheEnergyOfTheory) {
  // (1 + (omega dt)^2)^(-n) of the energy after n = 1 s / dt steps.
  for (const TableRow& row : read_rows("E3_implicit_euler_energy_left_after_1s.csv")) {
    const double hertz = row("mode Hz"), dt = row("dt"), expected = row("energy fraction left after 1 s");
    if (dt < 1e-3 || expected < 1e-30) continue;
    const double per_step = amplification("implicit_euler", 0.0, 2.0 * M_PI * hertz * dt);
    check("E2", "energy left after 1 s of " + row.text("mode Hz") + " Hz at dt " + row.text("dt"),
          std::pow(per_step, 2.0 * std::round(1.0 / dt)), expected, 1e-9);
  }
}

TEST(StableStep, IsTheExactOneOfASingleDampedMode) {
  // dt = limit(zeta) / omega, zeta = rate / (2 omega); heavily damped, motions without stiffness are the limit.
  for (const std::string& name : integrator_names()) {
    const auto scheme = make_integrator(name, {});
    for (const double zeta : {0.05, 0.1, 0.2}) {
      EXPECT_EQ(stable_step(*scheme, 100.0, 2.0 * zeta * 100.0), scheme->stability_limit(zeta) / 100.0) << name;
    }
    const double damped = stable_step(*scheme, 1e-3, 50.0);
    if (!std::isinf(damped)) {
      EXPECT_LT(amplification(name, 1e3, 0.99 * damped * 50.0 / 2e3), 1.0 + 1e-9) << name;
      EXPECT_GT(amplification(name, 1e3, 1.01 * damped * 50.0 / 2e3), 1.0) << name;
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
