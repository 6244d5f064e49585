// Sheets and points meeting every collider shape, at rest and fast.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "deformable_sim/core/contact/contact_finder.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::collider;

struct Drop {
  const char* name;
  Shape::Type type;
  Vec3 size;
};
std::ostream& operator<<(std::ostream& out, const Drop& d) {
  return out << d.name;
}

class SheetOn : public testing::TestWithParam<std::tuple<Drop, const char*>> {};

TEST_P(SheetOn, StaysOutsideWhileItFallsAndDrapes) {
  // Whatever the shape: no node, edge middle or face centroid deeper than 1 mm in the surface, at any step.
  const Drop& drop = std::get<0>(GetParam());
  test::Sheet sheet;
  sheet.size_x = sheet.size_y = 0.24;
  sheet.cells_x = sheet.cells_y = 16;
  sheet.contact_at_faces = true;
  sheet.membrane = 100.0;
  sheet.bend = 0.02;
  sheet.position = Vec3(0.01, 0.015, 0.02);
  const double top = drop.type == Shape::Type::kBox      ? 0.5 * drop.size.z()
                     : drop.type == Shape::Type::kSphere ? drop.size[0]
                     : drop.type == Shape::Type::kPlane  ? 0.0
                                                         : drop.size[0];
  const bool lies = drop.type == Shape::Type::kCylinder || drop.type == Shape::Type::kCapsule;
  const Collider shape =
      collider("c", drop.type, drop.size, lies ? at(0, 0, -top, M_PI / 2, Vec3(1, 0.3, 0)) : at(0, 0, -top));
  WorldSettings settings;
  settings.integrator = std::get<1>(GetParam());
  World world(test::sheet_model(sheet), settings, {shape}, {});
  double deepest = 0.0, strain = 0.0;
  for (int i = 0; i < 60; ++i) {
    const StepOutcome outcome = world.step();
    ASSERT_TRUE(outcome.ok) << i << ": " << outcome.message;
    deepest = std::max(deepest, measure_penetration(world.model(), world.snapshot().colliders, world.state().x));
    strain = std::max(strain, world.snapshot().bodies[0].max_strain);
  }
  EXPECT_LT(deepest, 0.001);
  EXPECT_GT(world.snapshot().bodies[0].contacts, 3);
  EXPECT_LT(strain, 0.2);
  // It fell 20 mm and lies on the shape.
  EXPECT_LT(world.state().x.row(2).mean(), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Every, SheetOn,
                         testing::Combine(testing::Values(Drop{"box", Shape::Type::kBox, Vec3(0.1, 0.1, 0.1)},
                                                          Drop{"sphere", Shape::Type::kSphere, Vec3(0.08, 0, 0)},
                                                          Drop{"cylinder", Shape::Type::kCylinder, Vec3(0.05, 0.15, 0)},
                                                          Drop{"capsule", Shape::Type::kCapsule, Vec3(0.05, 0.12, 0)},
                                                          Drop{"plane", Shape::Type::kPlane, Vec3::Zero()}),
                                          testing::Values("implicit_euler", "symplectic_euler")),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) + "_" + std::get<1>(info.param);
                         });

class FastMotion : public testing::TestWithParam<std::string> {};

TEST_P(FastMotion, DoesNotTunnelThroughAThinPlate) {
  // 180 mm a step against a plate of 2 mm: points that fly straight at its middle are still on their side at the end.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  const int n = 200;
  Nodes x(3, n), v(3, n);
  for (int i = 0; i < n; ++i) {
    x.col(i) = Vec3(0.3 * in(random), 0.3 * in(random), 0.1 + 0.09 * in(random));
    v.col(i) = 18.0 * Vec3(0.3 * in(random), 0.3 * in(random), -1.0).normalized();
  }
  WorldSettings settings;
  settings.integrator = GetParam();
  auto model = test::points_model(x, 0.001, Vec3(0, 0, -9.81));
  model->initial.v = v;
  World world(model, settings, {collider("plate", Shape::Type::kBox, Vec3(4, 4, 0.002), at(0, 0, -0.001))}, {});
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(world.step().ok);
    EXPECT_GT(world.state().x.row(2).minCoeff(), -1e-3);
  }
  // They met it: none went on falling, none was thrown back faster than it came.
  EXPECT_LT(world.state().v.colwise().norm().maxCoeff(), 18.0);
  EXPECT_LT(world.state().x.row(2).maxCoeff(), 0.01);
}

TEST_P(FastMotion, DoesNotLetAFastPlateThrough) {
  // The plate comes at 5 m/s, 50 mm a step, and turns; the points at rest end up pushed in front of it.
  Nodes x(3, 25);
  for (int i = 0; i < 25; ++i) x.col(i) = Vec3(0.02 * (i % 5) - 0.04, 0.02 * (i / 5) - 0.04, 0.0);
  WorldSettings settings;
  settings.integrator = GetParam();
  World world(test::points_model(x, 0.001, Vec3::Zero()), settings,
              {collider("plate", Shape::Type::kBox, Vec3(0.5, 0.5, 0.002), at(0, 0, -0.12))}, {});
  ASSERT_TRUE(world.apply(command::MoveCollider{"plate", at(0, 0, 0.2, 0.3, Vec3::UnitX()), 0.0}).status.ok());
  for (int i = 0; i < 15; ++i) {
    ASSERT_TRUE(world.step().ok);
    const Pose plate = world.snapshot().colliders[0].world_from_collider;
    const Nodes local = plate.inverse() * world.state().x;
    EXPECT_GT(local.row(2).minCoeff(), 0.001 - 5e-4) << i;
  }
}

TEST_P(FastMotion, DoesNotTunnelWhenAForceWasNotForeseen) {
  // Two masses at rest on both sides of a plate, drawn together by a stretched spring: within one step each would move
  // 50 mm, far beyond what their speed foretold.
  Nodes x = Nodes::Zero(3, 2);
  x(2, 0) = 0.04;
  x(2, 1) = -0.04;
  WorldSettings settings;
  settings.integrator = GetParam();
  settings.dt = 0.02;
  auto model = test::points_model(x, 0.01, Vec3::Zero());
  SpringLink link;
  link.b = 1;
  link.rest_length = 0.001;
  link.stiffness = 200.0;
  model->energies.push_back(make_springs("stretch springs", {link}, 0));
  World world(model, settings, {collider("plate", Shape::Type::kBox, Vec3(1, 1, 0.002), at(0, 0, 0))}, {});
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(world.step().ok);
    EXPECT_GT(world.state().x(2, 0), 0.0);
    EXPECT_LT(world.state().x(2, 1), 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, FastMotion, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST(ContactMomentum, IsWhatTheColliderGives) {
  // A point at rest on the floor: the contact force is its weight, and it does not move.
  WorldSettings settings;
  for (const std::string& scheme : integrator_names()) {
    settings.integrator = scheme;
    World world(test::points_model(Nodes::Zero(3, 1), 0.2, Vec3(0, 0, -9.81)), settings,
                {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))}, {});
    for (int i = 0; i < 50; ++i) ASSERT_TRUE(world.step().ok);
    // An implicit contact gives way by a hundredth of what the point would fall freely in a step, g dt^2 = 1 mm.
    EXPECT_NEAR(world.state().x(2, 0), 0.0, 2e-5) << scheme;
    EXPECT_EQ(world.snapshot().bodies[0].contacts, 1);
    ASSERT_EQ(world.snapshot().contact_force.size(), 1);
    EXPECT_NEAR(world.snapshot().contact_force[0], 0.2 * 9.81, 0.01);
  }
}

}  // namespace
}  // namespace deformable_sim
