// E6: trajectories computed by an independent program to 1e-11, and the errors a correct scheme makes against them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/golden_bodies.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

struct Golden {
  std::string name;
  double dt;         // s, of Runge-Kutta: its error (dt omega)^4 is below that of the table
  double tolerance;  // m; m/s a thousand times that
};

class GoldenBody : public testing::TestWithParam<Golden> {};
INSTANTIATE_TEST_SUITE_P(All, GoldenBody,
                         testing::Values(Golden{"chain10_soft", 5e-5, 1e-10},
                                         Golden{"chain10_soft_damped", 5e-5, 2e-11},
                                         Golden{"chain10_stiff", 1e-5, 1e-10}, Golden{"ring16", 2.5e-5, 1e-7},
                                         Golden{"provot6", 2.5e-5, 1e-11}, Golden{"lattice3", 2.5e-5, 2e-11}),
                         [](const auto& info) { return info.param.name; });

TEST_P(GoldenBody, IsReachedByRungeKuttaWithSmallSteps) {
  // x(t), v(t) of an independent integration at relative tolerance 1e-12; the ring, which buckles, is known to 5e-8 m.
  const Golden golden = GetParam();
  auto body = golden_body(golden.name);
  const auto integrator = make_integrator("rk4", {});
  double worst_x = 0.0, worst_v = 0.0;
  long taken = 0;
  for (const Instant& instant : golden_instants(golden.name, body->mass.size())) {
    for (const long wanted = std::lround(instant.time / golden.dt); taken < wanted; ++taken)
      body->step(*integrator, golden.dt);
    worst_x = std::max(worst_x, rms(body->state.x - instant.x));
    worst_v = std::max(worst_v, rms(body->state.v - instant.v));
  }
  EXPECT_GT(taken, 0);
  check("E6", golden.name + ", position error, m", worst_x, 0.0, golden.tolerance, Tolerance::kAbsolute);
  check("E6", golden.name + ", velocity error, m/s", worst_v, 0.0, 1e3 * golden.tolerance, Tolerance::kAbsolute);
}

const std::map<std::string, std::string> kTableName = {{"symplectic_euler", "symplectic_euler"},
                                                       {"velocity_verlet", "velocity_verlet"},
                                                       {"rk4", "rk4"},
                                                       {"implicit_euler", "implicit_euler"},
                                                       {"linear_implicit_euler", "linearised_implicit_euler(1 Newton)"},
                                                       {"implicit_midpoint", "implicit_midpoint"}};

class ExpectedError : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, ExpectedError, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

/// At the end of the table. Not finite when the scheme diverges.
Nodes end_of_golden(const std::string& name, const std::string& scheme, double dt, double time) {
  auto body = golden_body(name);
  const auto integrator = make_integrator(scheme, exact_settings(1e-7));
  const long steps = std::lround(time / dt);
  for (long k = 0; k < steps; ++k) body->step(*integrator, dt);
  return body->state.x;
}

TEST_P(ExpectedError, IsTheOneThatACorrectSchemeMakes) {
  // Within 2 % of the tabulated RMS error at the end, wherever that is below 0.1 m (above, branches of a whip decide)
  // and above what the tables themselves are good to. Midpoint steps of 5 ms and more depend on the branch that Newton
  // takes.
  if (kTableName.count(GetParam()) == 0) GTEST_SKIP() << "no rows for this scheme";
  int compared = 0;
  for (const TableRow& row : read_rows("expected_errors.csv")) {
    if (row.text("integrator") != kTableName.at(GetParam())) continue;
    const double dt = row("dt");
    if (GetParam() == "implicit_midpoint" && dt >= 5e-3) continue;
    const std::string name = row.text("case");
    const Instant last = golden_instants(name, golden_body(name)->mass.size()).back();
    SCOPED_TRACE(name + ", dt " + row.text("dt"));
    if (row.text("status") == "diverged") {
      const Nodes end = end_of_golden(name, GetParam(), dt, last.time);
      EXPECT_FALSE(end.allFinite() && end.norm() < 1e3);
      continue;
    }
    const double expected = row("RMS node position error at T [m]");
    if (expected >= 0.1 || expected < 3e-9) continue;
    const Nodes end = end_of_golden(name, GetParam(), dt, last.time);
    check("E6", GetParam() + ", error on " + name + " at dt " + row.text("dt") + ", m", rms(end - last.x), expected,
          0.02);
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

TEST(GoldenChain, IsApproachedToSecondOrderBySchemesThatTheTableLacks) {
  // error ~ dt^2: a quarter at half the step.
  const Instant last = golden_instants("chain10_soft_damped", 10).back();
  for (const std::string scheme : {"bdf2", "tr_bdf2"}) {
    const auto error = [&](double dt) {
      return rms(end_of_golden("chain10_soft_damped", scheme, dt, last.time) - last.x);
    };
    check("E6", scheme + ", error at dt 0.5 ms over that at 0.25 ms", error(5e-4) / error(2.5e-4), 4.0, 0.1);
  }
}

}  // namespace
}  // namespace deformable_sim::test
