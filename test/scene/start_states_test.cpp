// States set from outside: what crosses is refused by name, what overlaps comes apart softly, nothing is thrown.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/crossings.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

constexpr const char* kTwoSheets =
    "step: {solver: manual, dt: 0.005, integrator: implicit_euler}\n"
    "bodies:\n"
    "  - cloth: {name: lower, size: [0.2, 0.2], cells: [8, 8], pose: {position: [0, 0, 0.01]}, touches: all}\n"
    "  - cloth: {name: upper, size: [0.2, 0.2], cells: [9, 7], pose: {position: [0.005, 0.003, 0.03]}, touches: all}\n"
    "colliders:\n"
    "  - plane: {name: floor}\n";

command::SetBodyState state_of(const World& world, const std::string& name) {
  const Body& body = world.model().bodies[static_cast<size_t>(world.model().find_body(name))];
  return {name, world.state().x.middleCols(body.first_node, body.node_count),
          world.state().v.middleCols(body.first_node, body.node_count)};
}

double fastest(const World& world) {
  return world.state().v.colwise().norm().maxCoeff();
}

class SetStates : public testing::Test {
 protected:
  std::unique_ptr<World> world = build_world(load_scene_text(kTwoSheets, "text"));

  void expect_refused(const command::SetBodyState& command, const std::string& why) {
    const State before = world->state();
    const Reply reply = world->apply(command);
    EXPECT_EQ(reply.status.code, Code::kInvalidArgument);
    EXPECT_NE(reply.status.message.find(why), std::string::npos) << reply.status.message;
    EXPECT_TRUE(test::same_state(before, world->state()));
  }
};

TEST_F(SetStates, ThatCrossAnotherBodyAreRefusedByName) {
  for (int k = 0; k < 3; ++k) world->step();
  command::SetBodyState command = state_of(*world, "upper");
  // On edge, through the other sheet.
  for (int i = 0; i < command.x.cols(); ++i) command.x.col(i) = Vec3(0.001, command.x(1, i), 0.06 + command.x(0, i));
  expect_refused(command, "'lower' and 'upper' cross near (");
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(world->step().ok);
  EXPECT_EQ(test::count_crossings(world->model(), world->state().x), 0);
}

TEST_F(SetStates, ThatCrossThemselvesAreRefusedByName) {
  command::SetBodyState command = state_of(*world, "upper");
  // One half goes up through the other.
  for (int i = 0; i < command.x.cols(); ++i)
    if (command.x(0, i) > 0.02) command.x.col(i) = Vec3(-0.03, command.x(1, i) * 0.9 + 0.004, command.x(0, i) - 0.01);
  expect_refused(command, "'upper' crosses itself near (");
}

TEST_F(SetStates, AreTakenWhereNothingCrosses) {
  for (int k = 0; k < 3; ++k) world->step();
  command::SetBodyState command = state_of(*world, "upper");
  command.x.row(2).array() += 0.02;
  EXPECT_TRUE(world->apply(command).status.ok());
  EXPECT_EQ(state_of(*world, "upper").x, command.x);
}

TEST_F(SetStates, ThatLieTooNearComeApartSoftly) {
  // Distances of 0.1 mm where 2 mm are kept: apart at 0.3 m/s at most, beside what gravity gives.
  command::SetBodyState lower = state_of(*world, "lower"), upper = state_of(*world, "upper");
  upper.x.row(2).setConstant(lower.x(2, 0) + 0.0001);
  upper.v.setZero();
  ASSERT_TRUE(world->apply(upper).status.ok());
  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(world->step().ok);
    ASSERT_LT(fastest(*world), 0.3 + 9.81 * world->time() + 0.2) << "at " << world->time();
    ASSERT_EQ(test::count_crossings(world->model(), world->state().x), 0) << "at " << world->time();
  }
}

TEST_F(SetStates, WithoutADirectionFromNodeToNodeAreRefused) {
  command::SetBodyState command = state_of(*world, "upper");
  command.x.col(1) = command.x.col(0);
  expect_refused(command, "nodes 0 and 1 of 'upper' lie in one place");
  command.x.colwise() = Vec3(0.0, 0.0, 0.2);
  expect_refused(command, "lie in one place");
}

TEST(StartStates, InsideACollidersLeaveItSoftly) {
  // A sheet 30 mm deep in a box, another in a ball, a third in a floor: out at 0.3 m/s, and then they rest.
  for (const char* shape : {"box: {name: a, size: [0.5, 0.5, 0.1], pose: {position: [0, 0, 0.02]}}",
                            "sphere: {name: a, radius: 0.2, pose: {position: [0, 0, -0.13]}}",
                            "plane: {name: a, pose: {position: [0, 0, 0.03]}}"}) {
    const auto world = build_world(load_scene_text(
        "step: {solver: manual, dt: 0.005}\nbodies:\n"
        "  - cloth: {name: s, size: [0.2, 0.2], cells: [10, 10], pose: {position: [0, 0, 0.04]}}\ncolliders:\n  - " +
            std::string(shape) + "\n",
        "text"));
    for (int k = 0; k < 100; ++k) {
      ASSERT_TRUE(world->step().ok) << shape;
      ASSERT_LT(fastest(*world), 0.9) << shape << " at " << world->time();
      if (world->time() < 0.3) continue;
      ASSERT_LT(world->snapshot().max_penetration, 5e-4) << shape << " at " << world->time();
    }
  }
}

TEST(StartStates, OfASceneThatCrossNameTheLineOfTheLaterBody) {
  const std::string yaml =
      "bodies:\n"
      "  - cloth: {name: one, size: [0.5, 0.5], cells: [7, 9], touches: others}\n"
      "  - rope: {name: apart, length: 0.2, pose: {position: [3, 0, 0]}, touches: others}\n"
      "  - cloth: {name: two, touches: others, pose: {position: [0.01, 0.012, 0.004], rpy: [1.5, 0.1, 0]}}\n";
  try {
    build_world(load_scene_text(yaml, "s.yaml"));
    ADD_FAILURE() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("s.yaml:4: bodies[2]: 'one' and 'two' cross near ("), 0u) << error.what();
  }
}

}  // namespace
}  // namespace deformable_sim
