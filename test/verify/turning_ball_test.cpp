// H8: a cloth that lies on a turning ball turns with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/small_worlds.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

class TurningBall : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Schemes, TurningBall,
                         testing::Values("implicit_euler", "bdf2, linear_solver: multigrid", "tr_bdf2",
                                         "substepped_verlet"),
                         [](const auto& info) { return std::to_string(info.index); });

/// Turn about z of the cloth since `from`, rad, in (-pi, pi].
double turned(const Nodes& from, const Nodes& x) {
  const Vec3 a = from.rowwise().mean(), b = x.rowwise().mean();
  double along = 0.0, across = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const Vec3 p = from.col(i) - a, q = x.col(i) - b;
    along += p.head<2>().dot(q.head<2>());
    across += p.x() * q.y() - p.y() * q.x();
  }
  return std::atan2(across, along);
}

TEST_P(TurningBall, TakesTheClothAlong) {
  // A cap of 0.1 m on a ball of 0.3 m, mu = 0.4: tan(slope) = 0.35 at its corners. Half a turn a second asks omega^2 r
  // = 1 m/s^2 there, a quarter of mu g; getting up to it in a second 0.3 m/s^2. Slip below 1 % of a turn in each turn,
  // and the middle stays on the axis.
  constexpr double kOmega = M_PI, kSpinUp = 1.0, kTurns = 1.0;
  const auto world =
      build_world(load_scene_text(std::string("step: {solver: manual, dt: 0.01, integrator: ") + GetParam() + R"(}
air: {damping: 0.2}
bodies:
  - cloth: {name: cloth, size: [0.14, 0.14], cells: [10, 10], friction: 0.4, contact_radius: 0.001,
            pose: {position: [0, 0, 0.302]},
            material: {areal_density: 0.2, membrane_stiffness: 300, bending_rigidity: 1.0e-6, damping: 0.0005}}
colliders:
  - sphere: {name: ball, radius: 0.3, friction: 0.4}
)",
                                  "test"));
  const double dt = world->settings().dt;
  const auto turn_to = [&](double angle) {
    ASSERT_TRUE(world->apply(command::MoveCollider{"ball", at(0, 0, 0, angle, Vec3::UnitZ()), dt}).status.ok());
    ASSERT_TRUE(world->step().ok);
  };
  while (world->time() < 1.0 - 1e-9) ASSERT_NO_FATAL_FAILURE(turn_to(0.0));
  const Nodes settled = world->state().x;
  double angle = 0.0, most = 0.0, before = 0.0;
  for (double t = 0.0; t < kSpinUp + kTurns * 2.0 * M_PI / kOmega - 1e-9; t += dt) {
    angle += std::min(1.0, (t + dt) / kSpinUp) * kOmega * dt;
    ASSERT_NO_FATAL_FAILURE(turn_to(angle));
    const double lag = std::remainder(angle - turned(settled, world->state().x), 2.0 * M_PI);
    if (t < kSpinUp) before = lag;
    most = std::max(most, std::abs(lag - before));
  }
  check("H8", std::string("slip on a turning ball, turns a turn, ") + GetParam(), most / (2.0 * M_PI * kTurns), 0.0,
        0.01, Tolerance::kAbsolute);
  EXPECT_LT(std::abs(before), 0.01 * 2.0 * M_PI);  // getting up to speed
  EXPECT_LT(world->state().x.rowwise().mean().head<2>().norm(), 1e-3);
  EXPECT_EQ(world->snapshot().max_penetration, 0.0);
}

}  // namespace
}  // namespace deformable_sim::test
