// Colliders that come and go leave contacts with the others as they are.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/contact_finder.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

Collider slope() {
  return test::collider("slope", Shape::Type::kPlane, Vec3::Zero(), test::at(0, 0, 0, 0.35, Vec3::UnitY()));
}

Collider far_box(const std::string& name) {
  return test::collider(name, Shape::Type::kBox, Vec3(0.1, 0.1, 0.1), test::at(5, 0, 5));
}

/// A sheet that lies on a slope of 20 degrees; friction 0.5 holds it.
std::unique_ptr<World> sheet_on_slope() {
  test::Sheet sheet;
  sheet.size_x = sheet.size_y = 0.2;
  sheet.cells_x = sheet.cells_y = 6;
  auto model = test::sheet_model(sheet);
  const Mat3 turn = Eigen::AngleAxisd(0.35, Vec3::UnitY()).toRotationMatrix();
  for (int i = 0; i < model->initial.x.cols(); ++i)
    model->initial.x.col(i) = turn * (Vec3(model->initial.x.col(i)) + Vec3(0, 0, sheet.contact_radius));
  WorldSettings settings;
  settings.dt = 0.01;
  return std::make_unique<World>(model, settings, std::vector<Collider>{far_box("first"), slope()},
                                 std::vector<GraspRequest>());
}

TEST(ColliderChanges, DoNotLetGoWhatSticksToOthers) {
  // What sticks to a collider stays: < 1e-9 m in a second, whatever comes and goes elsewhere, before or behind it in
  // the list. (Stuck anew each time it would slip by some 15 um.)
  const auto world = sheet_on_slope();
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world->step().ok);
  const Nodes before = world->state().x;
  for (int k = 0; k < 100; ++k) {
    if (k % 5 == 0) world->apply(command::AddCollider{far_box("far")});
    if (k % 5 == 2) world->apply(command::RemoveCollider{"far"});
    if (k == 31) world->apply(command::RemoveCollider{"first"});
    if (k == 61) world->apply(command::LetThrough{"slope", {}});
    ASSERT_TRUE(world->step().ok);
  }
  EXPECT_LT((world->state().x - before).colwise().norm().maxCoeff(), 1e-9);
}

TEST(ColliderChanges, AreForgottenWithAReset) {
  // The same steps after a reset give the same bits, also where colliders were taken away and others came by their
  // names.
  const auto world = sheet_on_slope();
  for (int k = 0; k < 30; ++k) world->step();
  const Nodes first = world->state().x;
  world->apply(command::RemoveCollider{"slope"});
  world->apply(command::RemoveCollider{"first"});
  Collider other = slope();
  other.shapes[0].type = Shape::Type::kBox;
  other.shapes[0].size = Vec3(0.1, 0.1, 0.01);
  world->apply(command::AddCollider{other});
  world->apply(command::AddCollider{far_box("first")});
  for (int k = 0; k < 10; ++k) world->step();
  ASSERT_TRUE(world->apply(command::Reset()).status.ok());
  for (int k = 0; k < 30; ++k) world->step();
  EXPECT_EQ(first, world->state().x);
}

TEST(ColliderChanges, GiveAnotherColliderOfTheSameNameItsOwnShape) {
  auto model = test::points_model(Nodes(Vec3(0, 0, 0.0512)), 0.01, Vec3::Zero());
  model->bodies[0].contact_radius = 0.001;
  ContactFinder finder(model.get());
  const State& state = model->initial;
  const auto count = [&](const std::vector<Collider>& colliders) {
    finder.set_colliders(colliders);
    ContactConstraints contacts;
    finder.find(state, 0.01, std::vector<PoseStep>(colliders.size()), {NodeRole::kFree}, 0.0, &contacts);
    return contacts.size();
  };
  const Collider large = test::collider("a", Shape::Type::kBox, Vec3(0.1, 0.1, 0.1), Pose::Identity());
  const Collider small = test::collider("a", Shape::Type::kBox, Vec3(0.02, 0.02, 0.02), Pose::Identity());
  Collider other = large;
  other.name = "b";
  EXPECT_EQ(count({large}), 1u);
  EXPECT_EQ(count({small}), 0u);
  EXPECT_EQ(count({small, other}), 1u);
  EXPECT_EQ(count({other, small}), 1u);
  EXPECT_EQ(count({large, other}), 2u);
}

}  // namespace
}  // namespace deformable_sim
