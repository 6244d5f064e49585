// What every time scheme owes its caller: names, prescribed nodes, reactions, contacts, and no surprises.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/error.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

class EveryScheme : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Integrator> scheme() const { return make_integrator(GetParam(), exact_settings()); }
};

INSTANTIATE_TEST_SUITE_P(Registry, EveryScheme, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(EveryScheme, AnswersToItsName) {
  EXPECT_EQ(scheme()->name(), GetParam());
  EXPECT_GE(scheme()->order(), 1);
  // Who solves with a Jacobian, for tensions, or cuts the step by itself has no step limit, and only they.
  const bool free =
      scheme()->needs().jacobian || GetParam() == "substepped_verlet" || takes_known_terms_only(GetParam());
  EXPECT_EQ(free, std::isinf(scheme()->stability_limit()));
}

TEST_P(EveryScheme, AdvancesTime) {
  System body(Nodes::Zero(3, 1), Eigen::VectorXd::Ones(1));
  body.state.time = 2.0;
  body.step(*scheme(), 0.25);
  EXPECT_EQ(body.state.time, 2.25);
}

TEST_P(EveryScheme, TakesPrescribedNodesExactlyToTheirTargets) {
  System body(make_line(1.0, 2).rest, Eigen::Vector3d(1, 1, 1));
  LineStiffness stiffness;
  stiffness.axial = 50.0;
  stiffness.damping_time = 0.01;
  body.add_springs(line_network(make_line(1.0, 2), stiffness)).hold(0);
  body.dynamics.kinematics.target.col(0) = Vec3(-0.5, 0.01, 0.02);
  const auto integrator = scheme();
  body.step(*integrator, 0.01);
  EXPECT_EQ(body.state.x.col(0), Vec3(-0.5, 0.01, 0.02));
  EXPECT_LT((body.state.v.col(0) - Vec3(0, 1, 2)).norm(), 1e-12);
}

TEST_P(EveryScheme, ReportsTheWeightOfAHangingBodyAsReaction) {
  // At rest m a = 0: the holder exerts minus the spring force, which is the weight below it plus the node's own.
  const Polyline line = make_line(1.0, 4);
  System body(line.rest, line_masses(line, 0.5));
  LineStiffness stiffness;
  stiffness.axial = 500.0;
  stiffness.damping_time = 1e-3;
  body.add_springs(line_network(line, stiffness)).add_gravity().add(make_mass_damping(body.mass, 20.0)).hold(0);
  ASSERT_LT(relax(&body), 1e-6);
  const auto integrator = scheme();
  for (int k = 0; k < 5; ++k) body.step(*integrator, 1e-4);
  EXPECT_LT((body.dynamics.kinematics.reaction.col(0) - Vec3(0, 0, 0.5 * kGravity)).norm(), 1e-4);
}

TEST_P(EveryScheme, MovesAFullyPrescribedBodyWithoutTrouble) {
  System body(make_line(1.0, 1).rest, Eigen::Vector2d(1, 1));
  LineStiffness stiffness;
  stiffness.axial = 50.0;
  body.add_springs(line_network(make_line(1.0, 1), stiffness)).hold(0).hold(1);
  body.dynamics.kinematics.target.row(2).setConstant(0.1);
  EXPECT_TRUE(body.step(*scheme(), 0.01).converged);
  EXPECT_EQ(body.state.x(2, 1), 0.1);
}

TEST_P(EveryScheme, KeepsARestingBodyAtRest) {
  const TriangleMesh mesh = make_grid(1, 1, 3, 3);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add_springs(sheet_network(mesh, stiffness));
  const auto integrator = scheme();
  for (int k = 0; k < 200; ++k) body.step(*integrator, 1e-3);
  EXPECT_LT((body.state.x - mesh.rest).cwiseAbs().maxCoeff(), 1e-12);
}

TEST_P(EveryScheme, HoldsAFallingFaceOnAPlane) {
  // A contact point inside a face shares its force over three nodes of unlike masses: m g in total, no rotation left
  // over when the point is the centre of mass.
  System body((Nodes(3, 3) << 0, 1, 0, 0, 0, 1, 0.002, 0.002, 0.002).finished(), Eigen::Vector3d(0.2, 0.2, 0.2));
  body.add_gravity();
  body.build_pattern({{0, 1}, {1, 2}, {0, 2}});
  const auto integrator = scheme();
  const double dt = 2e-3;
  double impulse = 0.0;
  for (int k = 0; k < 250; ++k) {
    ContactConstraint c;
    c.node = {0, 1, 2, -1};
    c.weight = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    c.count = 3;
    c.friction = 0.5;
    body.dynamics.contacts = {c};
    body.step(*integrator, dt);
    impulse += dt * body.dynamics.contacts[0].force.z();
  }
  EXPECT_LT(body.state.x.row(2).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_NEAR(body.dynamics.contacts[0].force.z(), 0.6 * kGravity, 0.01 * 0.6 * kGravity);
  EXPECT_NEAR(impulse, 0.6 * kGravity * 0.5, 0.02 * 0.6 * kGravity * 0.5);
}

TEST(MakeIntegrator, RefusesAnUnknownNameWithTheAllowedOnes) {
  try {
    make_integrator("verlet", {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("explicit_euler, symplectic_euler, velocity_verlet, rk4, implicit_euler, "
                        "linear_implicit_euler, implicit_midpoint, bdf2, tr_bdf2, substepped_verlet, line_dual, "
                        "xpbd, projective_dynamics"),
              std::string::npos);
  }
}

TEST(ImplicitEuler, LeavesAHundredthOfTheFreeMotionOfAnImpact) {
  // k = 100 m / dt^2: at 3 m/s and dt = 10 ms, 30 mm of free motion become 0.3 mm at most.
  System body(Vec3(0, 0, 0.01), Eigen::VectorXd::Constant(1, 0.1));
  body.add_gravity();
  body.state.v = Vec3(0, 0, -3);
  const auto integrator = make_integrator("implicit_euler", {});
  for (int k = 0; k < 20; ++k) {
    body.dynamics.contacts.assign(1, ContactConstraint{});
    body.dynamics.contacts[0].node[0] = 0;
    body.step(*integrator, 0.01);
    EXPECT_GT(body.state.x(2, 0), -3e-4);
  }
  EXPECT_LT(body.state.v.norm(), 1e-3);
}

TEST(ImplicitEuler, SaysWhenItHasNotConverged) {
  SolverSettings settings = exact_settings(1e-9);
  settings.newton_iterations = 1;
  System body((Nodes(3, 2) << 0, 1.5, 0, 0, 0, 0).finished(), Eigen::Vector2d(1, 1));
  body.add(make_springs("spring", {{0, 1, 1.0, 500.0, 0.0}}, 0)).add_gravity().hold(0);
  const StepReport report = body.step(*make_integrator("implicit_euler", settings), 0.05);
  EXPECT_FALSE(report.converged);
  EXPECT_GT(report.residual, 1e-9);
}

TEST(ImplicitEuler, SolvesTheSameStepDirectlyAndByConjugateGradients) {
  const TriangleMesh mesh = make_grid(0.5, 0.5, 6, 6);
  SheetStiffness stiffness;
  stiffness.membrane = 200.0;
  stiffness.damping_time = 1e-3;
  Nodes end[2];
  int k = 0;
  for (const auto linear : {SolverSettings::Linear::kDirect, SolverSettings::Linear::kConjugateGradient}) {
    SolverSettings settings = exact_settings(1e-8);
    settings.linear = linear;
    System body(mesh.rest, sheet_masses(mesh, 0.15));
    body.add_springs(sheet_network(mesh, stiffness)).add_gravity().hold(0).hold(6);
    const auto integrator = make_integrator("implicit_euler", settings);
    for (int step = 0; step < 20; ++step) EXPECT_TRUE(body.step(*integrator, 5e-3).converged);
    end[k++] = body.state.x;
  }
  EXPECT_LT((end[0] - end[1]).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(HighestFrequency, OfAFreeChainIsItsClosedForm) {
  // omega_max = 2 sqrt(k/m) sin((n-1) pi / (2 n)) for n equal masses in a free chain.
  const int n = 24;
  System chain(make_line(1.0, n - 1).rest, Eigen::VectorXd::Constant(n, 0.02));
  LineStiffness stiffness;
  stiffness.stretch = 700.0;
  stiffness.bend = 0.0;
  chain.add_springs(line_network(make_line(1.0, n - 1), stiffness));
  const double expected = 2.0 * std::sqrt(700.0 / 0.02) * std::sin(0.5 * M_PI * (n - 1) / n);
  EXPECT_NEAR(highest_frequency(chain.dynamics, chain.state), expected, 1e-3 * expected);
}

TEST(HighestFrequency, IsWithinAPercentWhereThatWillDo) {
  // The same chain by one-sided differences; its highest frequencies lie close together, as those of fine meshes do.
  const int n = 200;
  System chain(make_line(1.0, n - 1).rest, Eigen::VectorXd::Constant(n, 0.002));
  LineStiffness stiffness;
  stiffness.stretch = 9000.0;
  stiffness.bend = 0.0;
  chain.add_springs(line_network(make_line(1.0, n - 1), stiffness));
  const double expected = 2.0 * std::sqrt(9000.0 / 0.002) * std::sin(0.5 * M_PI * (n - 1) / n);
  EXPECT_NEAR(highest_frequency(chain.dynamics, chain.state, Effort::kRough), expected, 0.01 * expected);
}

TEST(HighestDampingRate, OfDampedSpringsIsTheirTimeTimesTheSquareOfTheFrequency) {
  // C = damping_time K: the fastest motion that only damps has the rate damping_time omega_max^2.
  const int n = 200;
  System chain(make_line(1.0, n - 1).rest, Eigen::VectorXd::Constant(n, 0.002));
  LineStiffness stiffness;
  stiffness.stretch = 9000.0;
  stiffness.bend = 0.0;
  stiffness.damping_time = 1e-3;
  chain.add_springs(line_network(make_line(1.0, n - 1), stiffness));
  const double omega = 2.0 * std::sqrt(9000.0 / 0.002) * std::sin(0.5 * M_PI * (n - 1) / n),
               rate = 1e-3 * omega * omega;
  EXPECT_NEAR(highest_damping_rate(chain.dynamics, chain.state, Effort::kRough), rate, 0.02 * rate);
}

TEST(HighestFrequency, HoldsPrescribedNodes) {
  System body((Nodes(3, 2) << 0, 1, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 0.5));
  body.add(make_springs("spring", {{0, 1, 1.0, 200.0, 0.0}}, 0)).hold(0);
  EXPECT_NEAR(highest_frequency(body.dynamics, body.state), 20.0, 1e-4);
}

TEST(ImplicitEuler, LetsNothingFarThroughEvenWhenItDoesNotConverge) {
  // A penalty of 100 m / dt^2 stops 18 m/s * 10 ms 1.8 mm deep; a solve that counts as unconverged ends at most 0.3 mm
  // deep.
  SolverSettings settings = exact_settings();
  settings.tolerance = -1.0;  // never met
  const auto scheme = make_integrator("implicit_euler", settings);
  System body(Nodes::Zero(3, 1), Eigen::VectorXd::Ones(1));
  body.state.v.col(0) = Vec3(0, 0, -18);
  body.dynamics.contacts.resize(1);
  body.dynamics.contacts[0].node[0] = 0;
  const StepReport report = body.step(*scheme, 0.01);
  EXPECT_FALSE(report.converged);
  EXPECT_LT(body.state.x(2, 0), 0.0);
  EXPECT_GE(body.state.x(2, 0), -3.001e-4);
}

}  // namespace
}  // namespace deformable_sim::test
