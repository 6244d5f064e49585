// What every time scheme owes its caller beyond a single step: the future from the state alone, forces that balance.
#include <gtest/gtest.h>

#include <cmath>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

class SchemeState : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Integrator> scheme() const { return make_integrator(GetParam(), exact_settings(1e-9)); }
};
INSTANTIATE_TEST_SUITE_P(Registry, SchemeState, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

/// A rope of damped springs, held at its first node.
std::unique_ptr<System> rope() {
  const Polyline line = make_line(1.0, 6);
  auto body = std::make_unique<System>(line.rest, line_masses(line, 0.3));
  LineStiffness stiffness;
  stiffness.axial = 100.0;
  stiffness.damping_time = 2e-3;
  body->add_springs(line_network(line, stiffness)).add_gravity().hold(0);
  return body;
}

/// One step under a moving holder, above a floor at z = -0.1.
void step(System* body, Integrator* integrator, double dt) {
  body->dynamics.kinematics.target(2, 0) = 0.02 * std::sin(20.0 * (body->state.time + dt));
  body->dynamics.contacts.clear();
  for (int i = 1; i < 7; ++i) {
    if (body->state.x(2, i) > -0.09) continue;
    ContactConstraint c;
    c.node[0] = i;
    c.offset = -0.1;
    c.friction = 0.4;
    body->dynamics.contacts.push_back(c);
  }
  body->step(*integrator, dt);
}

TEST_P(SchemeState, DeterminesTheFutureAlone) {
  // A scheme that has made the steps so far and one that is new go on with the same bits.
  auto first = rope(), second = rope();
  const auto old = scheme();
  for (int k = 0; k < 200; ++k) step(first.get(), old.get(), 1e-3 * (1.0 + 0.3 * (k % 3)));
  EXPECT_FALSE(first->dynamics.contacts.empty());
  second->state = first->state;
  second->build_pattern();
  const auto fresh = scheme();
  for (int k = 0; k < 20; ++k) {
    step(first.get(), old.get(), 1e-3);
    step(second.get(), fresh.get(), 1e-3);
  }
  EXPECT_EQ(first->state.x, second->state.x);
  EXPECT_EQ(first->state.v, second->state.v);
}

TEST_P(SchemeState, BalancesMomentumWithTheHoldersForce) {
  // Change of momentum = integral of weight and reaction. BDF2 takes its acceleration from three velocities: the
  // integral lags by half a step's change.
  auto body = rope();
  const auto integrator = scheme();
  const double dt = 1e-3;
  Vec3 impulse = Vec3::Zero();
  const int steps = 150;
  for (int k = 1; k <= steps; ++k) {
    body->dynamics.kinematics.target(2, 0) = 0.05 * (1.0 - std::cos(20.0 * k * dt));
    body->step(*integrator, dt);
    impulse += dt * (body->dynamics.kinematics.reaction.col(0) + body->mass.sum() * Vec3(0, 0, -kGravity));
  }
  const Vec3 momentum = body->state.v * body->mass;
  EXPECT_GT(momentum.norm(), 0.1);
  const double lag = GetParam() == "bdf2" || GetParam() == "line_dual" ? dt * 2.0 * body->mass.sum() * kGravity : 0.0;
  EXPECT_LT((impulse - momentum).norm(), 1e-9 + lag);
}

TEST_P(SchemeState, MovesPrescribedNodesAlongOneStraightPath) {
  // A free node tied by a damper alone to a holder of constant velocity takes up that velocity: v = V (1 - exp(-c
  // t/m)).
  System body(Nodes::Zero(3, 2), Eigen::Vector2d(1.0, 0.5));
  body.state.x(0, 1) = 1.0;
  body.add(make_springs("damper", {{0, 1, 1.0, 0.0, 3.0}}, 0)).hold(0);
  body.state.v(0, 0) = 0.2;
  const auto integrator = scheme();
  const double dt = 1e-3;
  for (int k = 1; k <= 200; ++k) {
    body.dynamics.kinematics.target(0, 0) = 0.2 * dt * k;
    body.step(*integrator, dt);
    EXPECT_NEAR(body.state.v(0, 0), 0.2, 1e-9);
  }
  // First order in forces of velocity: (c dt / m) / 2 of exp(-c t / m) c t / m.
  const double rate = 3.0 / 0.5, decay = std::exp(-rate * 0.2);
  const double tolerance = scheme()->order_with_velocity_forces() == 1 ? rate * dt * rate * 0.2 * decay : 1e-5;
  EXPECT_NEAR(body.state.v(0, 1), 0.2 * (1.0 - decay), 0.2 * tolerance);
}

TEST_P(SchemeState, CarriesABodyOnARisingFloor) {
  // The planes of a step are those at its end: a stage meets the floor where it then is. The body keeps to the floor
  // and the floor carries the weight.
  System body(Vec3(0, 0, 0), Eigen::VectorXd::Constant(1, 0.3));
  body.add_gravity();
  const auto integrator = scheme();
  const double dt = 2e-3, speed = 0.5;
  body.state.v(2, 0) = speed;
  double impulse = 0.0;
  const int steps = 200;
  for (int k = 1; k <= steps; ++k) {
    ContactConstraint c;
    c.node[0] = 0;
    c.offset = speed * dt * k;
    c.surface_velocity = Vec3(0, 0, speed);
    body.dynamics.contacts.assign(1, c);
    body.step(*integrator, dt);
    EXPECT_NEAR(body.state.x(2, 0), c.offset, 1e-5) << k;
    impulse += dt * body.dynamics.contacts[0].force.z();
  }
  EXPECT_NEAR(impulse, 0.3 * kGravity * steps * dt, 0.01 * 0.3 * kGravity * steps * dt);
}

TEST_P(SchemeState, StopsABodyThatHitsTheFloor) {
  // Inelastic: no scheme throws it back, whatever it remembers or extrapolates. The first stage of TR-BDF2 sinks in by
  // 1/60 of its way (9 mm), which the second makes good within 2 ms: a hop of a quarter of a millimetre.
  System body(Vec3(0, 0, 0.03), Eigen::VectorXd::Constant(1, 0.3));
  body.add_gravity();
  body.state.v(2, 0) = -3.0;
  const auto integrator = scheme();
  double highest = -1.0;
  for (int k = 0; k < 40; ++k) {
    body.dynamics.contacts.assign(1, ContactConstraint());
    body.dynamics.contacts[0].node[0] = 0;
    body.step(*integrator, 5e-3);
    EXPECT_GT(body.state.x(2, 0), -5e-4);
    if (k > 4) highest = std::max(highest, body.state.x(2, 0));
  }
  EXPECT_LT(highest, GetParam() == "tr_bdf2" ? 3e-4 : 1e-5);
  EXPECT_LT(body.state.v.norm(), 1e-3);
}

TEST(Bdf2, RemembersOneStateAndNoOtherFormulaDoes) {
  for (const std::string& name : integrator_names()) {
    auto body = rope();
    const auto integrator = make_integrator(name, exact_settings());
    body->step(*integrator, 1e-3);
    const State one = body->state;
    body->step(*integrator, 2e-3);
    if (name == "bdf2" || name == "line_dual") {
      EXPECT_EQ(body->state.x_before, one.x);
      EXPECT_EQ(body->state.v_before, one.v);
      EXPECT_EQ(body->state.dt_before, 2e-3);
    } else {
      EXPECT_EQ(body->state.x_before.cols(), 0) << name;
    }
  }
}

TEST(Bdf2, BeginsWithTrBdf2AndAgainAfterAStepThatIsMuchLonger) {
  for (const double second : {1e-3, 2.1e-3}) {
    auto body = rope(), other = rope();
    const auto integrator = make_integrator("bdf2", exact_settings());
    const auto start = make_integrator("tr_bdf2", exact_settings());
    body->step(*integrator, 1e-3);
    other->step(*start, 1e-3);
    EXPECT_EQ(body->state.x, other->state.x);
    body->step(*integrator, second);
    other->step(*start, second);
    EXPECT_EQ(body->state.x == other->state.x, second > 2e-3);
  }
}

TEST(Bdf2, ForgetsAnImpactWhoseContactIsGone) {
  // The extrapolated velocity would be 4/3 of what is left less 1/3 of what came: 1 m/s upwards of -3 m/s.
  System body(Vec3(0, 0, 0.1), Eigen::VectorXd::Constant(1, 0.3));
  body.state.v(2, 0) = -3.0;
  const auto integrator = make_integrator("bdf2", exact_settings());
  for (int k = 0; k < 3; ++k) body.step(*integrator, 0.01);
  body.state.x(2, 0) = 0.0;
  body.dynamics.contacts.assign(1, ContactConstraint());
  body.dynamics.contacts[0].node[0] = 0;
  body.step(*integrator, 0.01);
  body.dynamics.contacts.clear();
  body.step(*integrator, 0.01);
  EXPECT_LT(body.state.v.norm(), 0.05);
}

TEST(LinearImplicitEuler, IsImplicitEulerWhereForcesAreLinear) {
  System a((Nodes(3, 2) << 0, 1.2, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 0.5));
  System b(a.state.x, a.mass);
  for (System* body : {&a, &b}) body->add(make_springs("spring", {{0, 1, 1.0, 200.0, 0.7}}, 0)).hold(0);
  const auto linear = make_integrator("linear_implicit_euler", exact_settings());
  const auto newton = make_integrator("implicit_euler", exact_settings());
  for (int k = 0; k < 30; ++k) {
    EXPECT_LE(a.step(*linear, 0.05).newton_iterations, 1);
    b.step(*newton, 0.05);
  }
  EXPECT_LT((a.state.x - b.state.x).norm(), 1e-12);
}

TEST(LinearImplicitEuler, TakesTheProjectedMatrixWhereTheFullOneIsNotDefinite) {
  // A spring compressed to half its length pushes sideways with k (1 - L/r) = -k: m / dt^2 < k makes M / dt^2 - K
  // indefinite, and its solution would run towards the unstable direction's other side.
  for (const auto linear : {SolverSettings::Linear::kDirect, SolverSettings::Linear::kConjugateGradient}) {
    SolverSettings settings = exact_settings(1e-6);
    settings.linear = linear;
    System body((Nodes(3, 2) << 0, 0.5, 0, 0, 0, 0).finished(), Eigen::Vector2d(1.0, 1.0));
    body.add(make_springs("spring", {{0, 1, 1.0, 100.0, 0.0}}, 0)).hold(0);
    body.state.v.col(1) = Vec3(0, 0.1, 0);
    EXPECT_TRUE(body.step(*make_integrator("linear_implicit_euler", settings), 0.2).converged);
    // Along the spring k = 100 acts, across it nothing does: (x - 0.5)(1 / dt^2 + k) = 50, y = v dt.
    EXPECT_NEAR(body.state.x(0, 1), 0.5 + 50.0 / 125.0, 1e-6);
    EXPECT_NEAR(body.state.x(1, 1), 0.02, 1e-6);
  }
}

TEST(ImplicitEuler, ReachesTheSameStepWithTheAxialJacobian) {
  // The matrix decides the way, not the end.
  Nodes end[2];
  int iterations[2] = {0, 0};
  for (const Jacobian kind : {Jacobian::kProjected, Jacobian::kAxial}) {
    SolverSettings settings = exact_settings(1e-9);
    settings.jacobian = kind;
    auto body = rope();
    const auto integrator = make_integrator("implicit_euler", settings);
    const int k = kind == Jacobian::kAxial ? 1 : 0;
    for (int n = 0; n < 50; ++n) iterations[k] += body->step(*integrator, 5e-3).newton_iterations;
    end[k] = body->state.x;
  }
  EXPECT_LT((end[0] - end[1]).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_GT(iterations[1], iterations[0]);
}

}  // namespace
}  // namespace deformable_sim::test
