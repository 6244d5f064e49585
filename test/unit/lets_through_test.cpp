// Colliders that let some bodies through and stop the others.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/core/error.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

/// Two loose points, bodies "a" and "b", that fall on a table of 0.1 m side by side.
std::shared_ptr<Model> two_points() {
  Nodes x(3, 2);
  x << -0.02, 0.02, 0, 0, 0.01, 0.01;
  auto model = test::points_model(x, 0.01, Vec3(0, 0, -9.81));
  model->bodies[0].name = "a";
  model->bodies[0].node_count = 1;
  model->bodies[0].contact_radius = 0.001;
  model->bodies.push_back(model->bodies[0]);
  model->bodies[1].name = "b";
  model->bodies[1].first_node = 1;
  return model;
}

Collider table(const std::vector<std::string>& lets_through) {
  Collider c = test::collider("table", Shape::Type::kBox, Vec3(0.1, 0.1, 0.02), test::at(0, 0, -0.01));
  c.lets_through = lets_through;
  return c;
}

WorldSettings settings() {
  WorldSettings s;
  s.dt = 0.005;
  return s;
}

TEST(LetsThrough, OneBodyFallsThroughTheOtherLies) {
  // z = z0 - g t (t + dt) / 2 for who falls freely (implicit Euler); z = r for who lies.
  World world(two_points(), settings(), {table({"a"})}, {});
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(world.step().ok);
  const double t = world.time();
  EXPECT_NEAR(world.state().x(2, 0), 0.01 - 0.5 * 9.81 * t * (t + 0.005), 1e-9);
  EXPECT_NEAR(world.state().x(2, 1), 0.001, 1e-4);
  EXPECT_EQ(world.snapshot().max_penetration, 0.0);
}

TEST(LetsThrough, IsChangedWhileTheWorldRuns) {
  World world(two_points(), settings(), {table({"a", "b"})}, {});
  ASSERT_TRUE(world.apply(command::LetThrough{"table", {"a"}}).status.ok());
  for (int k = 0; k < 40; ++k) world.step();
  EXPECT_NEAR(world.state().x(2, 1), 0.001, 1e-4);
  ASSERT_TRUE(world.apply(command::LetThrough{"table", {"b"}}).status.ok());
  for (int k = 0; k < 40; ++k) world.step();
  EXPECT_LT(world.state().x(2, 1), -0.1);
  ASSERT_TRUE(world.apply(command::Reset()).status.ok());  // both again
  for (int k = 0; k < 40; ++k) world.step();
  EXPECT_LT(world.state().x.row(2).maxCoeff(), -0.1);
}

TEST(LetsThrough, IsRefusedForNamesThatDoNotExist) {
  World world(two_points(), settings(), {table({})}, {});
  Reply reply = world.apply(command::LetThrough{"chair", {"a"}});
  EXPECT_EQ(reply.status.code, Code::kNotFound);
  EXPECT_NE(reply.status.message.find("'chair'; there are: table"), std::string::npos) << reply.status.message;
  reply = world.apply(command::LetThrough{"table", {"a", "c"}});
  EXPECT_EQ(reply.status.code, Code::kNotFound);
  EXPECT_NE(reply.status.message.find("'c'; there are: a, b"), std::string::npos) << reply.status.message;
  Collider other = table({"c"});
  other.name = "other";
  EXPECT_EQ(world.apply(command::AddCollider{other}).status.code, Code::kNotFound);
  for (int k = 0; k < 40; ++k) world.step();
  EXPECT_NEAR(world.state().x.row(2).minCoeff(), 0.001, 1e-4);
}

}  // namespace
}  // namespace deformable_sim
