// The step, commands and reports of a World.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::collider;
using test::grasp_nodes;

WorldSettings settings(const std::string& integrator = "implicit_euler", double dt = 0.01) {
  WorldSettings s;
  s.integrator = integrator;
  s.dt = dt;
  return s;
}

test::Sheet small_sheet() {
  test::Sheet sheet;
  sheet.size_x = sheet.size_y = 0.2;
  sheet.cells_x = sheet.cells_y = 8;
  return sheet;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A grasp, a collider and a few steps: something of everything to change by mistake.
std::unique_ptr<World> busy_world() {
  test::Sheet sheet = small_sheet();
  sheet.position = Vec3(0, 0, 0.05);
  GraspRequest corner = grasp_nodes("left", "towel", {0});
  auto world = std::make_unique<World>(
      test::sheet_model(sheet), settings(),
      std::vector<Collider>{collider("table", Shape::Type::kBox, Vec3(1, 1, 0.1), at(0, 0, -0.05))},
      std::vector<GraspRequest>{corner});
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(world->step().ok);
  return world;
}

TEST(World, FallsFreely) {
  // Backward Euler from rest: z(t) = -g t (t + dt) / 2 exactly, and x, y stay.
  Nodes x = Nodes::Zero(3, 2);
  x(0, 1) = 1.0;
  World world(test::points_model(x, 0.1, Vec3(0, 0, -9.81)), settings(), {}, {});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(world.step().ok);
  EXPECT_EQ(world.time(), 1.0);
  EXPECT_EQ(world.step_count(), 100u);
  // Newton stops at 0.02 m/s^2 at worst; a linear problem is solved in one iteration.
  EXPECT_NEAR(world.state().x(2, 0), -0.5 * 9.81 * 1.0 * 1.01, 1e-6);
  EXPECT_NEAR(world.state().x(0, 1), 1.0, 1e-12);
}

TEST(World, RefusesBadSettingsAndParts) {
  const auto model = test::points_model(Nodes::Zero(3, 1), 0.1, Vec3::Zero());
  for (double dt : {0.0, -0.01, std::nan(""), 9e-10, 2.1})
    EXPECT_THROW(World(model, settings("implicit_euler", dt), {}, {}), InputError);
  EXPECT_THROW(World(model, settings("leapfrog"), {}, {}), InputError);
  WorldSettings s = settings();
  s.grasp_max_speed = 0.0;
  EXPECT_THROW(World(model, s, {}, {}), InputError);
  s = settings();
  s.collider_max_speed = -1.0;
  EXPECT_THROW(World(model, s, {}, {}), InputError);
  EXPECT_THROW(World(model, settings(), {collider("", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))}, {}),
               InputError);
  EXPECT_THROW(World(model, settings(), {}, {grasp_nodes("g", "points", {1})}), InputError);
}

TEST(World, RefusesEachBadCommandWithoutChangingABit) {
  const auto world = busy_world();
  const State before = world->state();
  const Snapshot shown = world->snapshot();
  Pose nan_pose = at(0, 0, 0);
  nan_pose.translation().y() = std::nan("");
  const Eigen::Index n = world->model().node_count();
  const Nodes x = before.x, v = before.v;
  Nodes far = x, fast = v, not_finite = x;
  far(0, 0) = 2e6;
  fast(0, 0) = 2e4;
  not_finite(1, 3) = std::nan("");
  GraspRequest bad_stiffness = grasp_nodes("g", "towel", {3});
  bad_stiffness.stiffness = -1.0;

  struct Row {
    Command command;
    Code code;
    const char* word;
  };
  const std::vector<Row> rows = {
      {command::Grasp{grasp_nodes("g", "shirt", {0})}, Code::kNotFound, "towel"},
      {command::Grasp{grasp_nodes("left", "towel", {5})}, Code::kAlreadyExists, "left"},
      {command::Grasp{grasp_nodes("g", "towel", {0})}, Code::kUnavailable, "held by grasp 'left'"},
      {command::Grasp{grasp_nodes("g", "towel", {999999})}, Code::kOutOfRange, "0 to 80"},
      {command::Grasp{bad_stiffness}, Code::kInvalidArgument, "stiffness"},
      {command::MoveGrasp{"left", nan_pose, 0.0}, Code::kInvalidArgument, "finite"},
      {command::MoveGrasp{"left", at(0, 0, 0), -1.0}, Code::kInvalidArgument, "duration"},
      {command::MoveGrasp{"right", at(0, 0, 0), 0.0}, Code::kNotFound, "left"},
      {command::SetGraspWaiting{"right", true}, Code::kNotFound, "left"},
      {command::Release{"right"}, Code::kNotFound, "left"},
      {command::AddCollider{collider("table", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0))}, Code::kAlreadyExists,
       "table"},
      {command::AddCollider{collider("ball", Shape::Type::kSphere, Vec3(-1, 0, 0), at(0, 0, 0))},
       Code::kInvalidArgument, "sizes"},
      {command::MoveCollider{"table", nan_pose, 0.0}, Code::kInvalidArgument, "finite"},
      {command::MoveCollider{"table", at(0, 0, 0), std::nan("")}, Code::kInvalidArgument, "duration"},
      {command::MoveCollider{"ball", at(0, 0, 0), 0.0}, Code::kNotFound, "table"},
      {command::RemoveCollider{"ball"}, Code::kNotFound, "table"},
      {command::SetBodyState{"shirt", x, v}, Code::kNotFound, "towel"},
      {command::SetBodyState{"towel", x.leftCols(n - 1), v}, Code::kInvalidArgument, "81 nodes"},
      {command::SetBodyState{"towel", x, v.leftCols(0)}, Code::kInvalidArgument, "81 nodes"},
      {command::SetBodyState{"towel", not_finite, v}, Code::kInvalidArgument, "finite"},
      {command::SetBodyState{"towel", x, not_finite}, Code::kInvalidArgument, "finite"},
      {command::SetBodyState{"towel", far, v}, Code::kOutOfRange, "1e6"},
      {command::SetBodyState{"towel", x, fast}, Code::kOutOfRange, "1e4"},
  };
  for (const Row& row : rows) {
    const Reply reply = world->apply(row.command);
    EXPECT_EQ(reply.status.code, row.code) << reply.status.message;
    EXPECT_TRUE(contains(reply.status.message, row.word)) << reply.status.message;
    EXPECT_TRUE(test::same_state(world->state(), before));
  }
  const Snapshot now = world->snapshot();
  ASSERT_EQ(now.grasps.size(), 1u);
  EXPECT_EQ(now.grasps[0].world_from_grasp.matrix(), shown.grasps[0].world_from_grasp.matrix());
  ASSERT_EQ(now.colliders.size(), 1u);
  EXPECT_EQ(now.colliders[0].world_from_collider.matrix(), shown.colliders[0].world_from_collider.matrix());

  // And the future is the one it would have had.
  const auto twin = busy_world();
  for (int i = 0; i < 5; ++i) {
    world->step();
    twin->step();
  }
  EXPECT_TRUE(test::same_state(world->state(), twin->state()));
}

TEST(World, RepeatsItselfToTheLastBit) {
  // The same commands at the same steps give the same state, in a second world and after a reset of the first.
  const auto play = [](World* world) {
    world->apply(command::Grasp{grasp_nodes("right", "towel", {8})});
    world->apply(command::MoveGrasp{"right", at(0.1, -0.1, 0.2), 0.2});
    world->apply(command::MoveCollider{"table", at(0, 0, -0.04), 0.1});
    for (int i = 0; i < 30; ++i) world->step();
    world->apply(command::Release{"left"});
    world->apply(command::AddCollider{collider("ball", Shape::Type::kSphere, Vec3(0.05, 0, 0), at(0, 0, 0.02))});
    for (int i = 0; i < 30; ++i) world->step();
  };
  const auto a = busy_world(), b = busy_world();
  play(a.get());
  play(b.get());
  EXPECT_TRUE(test::same_state(a->state(), b->state()));
  const State once = a->state();
  ASSERT_TRUE(a->apply(command::Reset{}).status.ok());
  EXPECT_EQ(a->time(), 0.0);
  EXPECT_EQ(a->step_count(), 0u);
  EXPECT_EQ(a->state().x, a->model().initial.x);
  EXPECT_EQ(a->snapshot().colliders.size(), 1u);
  for (int i = 0; i < 5; ++i) a->step();
  play(a.get());
  EXPECT_TRUE(test::same_state(a->state(), once));
}

TEST(World, LooksOnWithoutChangingAnything) {
  const auto watched = busy_world(), alone = busy_world();
  for (int i = 0; i < 20; ++i) {
    watched->snapshot();
    watched->bill();
    watched->step();
    alone->step();
  }
  EXPECT_TRUE(test::same_state(watched->state(), alone->state()));
}

TEST(World, WeighsATowelHeldByTwoGrasps) {
  // At rest the wrenches add up to the weight, m g downwards on the grippers.
  test::Sheet sheet = small_sheet();
  sheet.mass_damping = 4.0;
  World world(test::sheet_model(sheet), settings(), {},
              {grasp_nodes("left", "towel", {0, 1}), grasp_nodes("right", "towel", {7, 8})});
  for (int i = 0; i < 400; ++i) ASSERT_TRUE(world.step().ok);
  const Snapshot s = world.snapshot();
  ASSERT_LT(s.v.colwise().norm().maxCoeff(), 0.01);
  const double weight = 9.81 * world.model().mass.sum();
  const Vec3 total = s.grasps[0].force + s.grasps[1].force;
  EXPECT_NEAR(total.z(), -weight, 0.01 * weight);
  EXPECT_NEAR(total.x(), 0.0, 0.01 * weight);
  EXPECT_NEAR(total.y(), 0.0, 0.01 * weight);
}

TEST(World, WeighsATowelHeldSoftly) {
  GraspRequest left = grasp_nodes("left", "towel", {0, 1}), right = grasp_nodes("right", "towel", {7, 8});
  left.stiffness = right.stiffness = 50.0;
  test::Sheet sheet = small_sheet();
  sheet.mass_damping = 4.0;
  World world(test::sheet_model(sheet), settings(), {}, {left, right});
  for (int i = 0; i < 400; ++i) ASSERT_TRUE(world.step().ok);
  const Snapshot s = world.snapshot();
  const double weight = 9.81 * world.model().mass.sum();
  EXPECT_NEAR((s.grasps[0].force + s.grasps[1].force).z(), -weight, 0.01 * weight);
  // And the springs are as long as that force makes them: k d = W / 2 each.
  EXPECT_NEAR(s.x.col(0).z() + s.x.col(1).z(), -2.0 * weight / 2.0 / 50.0, 0.1 * weight / 50.0);
}

TEST(World, LetsGoWithoutAJump) {
  // A single mass carried at 0.5 m/s and released goes on at 0.5 m/s: x(t) = v t.
  World world(test::points_model(Nodes::Zero(3, 1), 0.1, Vec3::Zero()), settings(), {},
              {grasp_nodes("g", "points", {0})});
  world.apply(command::MoveGrasp{"g", at(0.5, 0, 0), 1.0});
  for (int i = 0; i < 50; ++i) world.step();
  EXPECT_NEAR(world.state().v(0, 0), 0.5, 1e-9);
  world.apply(command::Release{""});
  for (int i = 0; i < 50; ++i) world.step();
  EXPECT_NEAR(world.state().x(0, 0), 0.5, 1e-9);
  EXPECT_TRUE(world.snapshot().grasps.empty());
}

TEST(World, DropsWhatWeighsMoreThanTheGraspBears) {
  // 0.1 kg weighs 0.981 N: borne by a grasp of 1 N, not by one of 0.9 N.
  for (double max_force : {1.0, 0.9}) {
    GraspRequest r = grasp_nodes("g", "points", {0});
    r.max_force = max_force;
    World world(test::points_model(Nodes::Zero(3, 1), 0.1, Vec3(0, 0, -9.81)), settings(), {}, {r});
    for (int i = 0; i < 10; ++i) world.step();
    const Snapshot s = world.snapshot();
    const bool held = max_force > 0.981;
    EXPECT_EQ(s.grasps[0].phase, held ? GraspPhase::kHolding : GraspPhase::kSlipped);
    EXPECT_EQ(s.x(2, 0) == 0.0, held);
    if (held) {
      EXPECT_NEAR(s.grasps[0].load, 0.981, 1e-6);
    }
    world.apply(command::Release{"g"});
    EXPECT_TRUE(world.snapshot().grasps.empty());
  }
}

TEST(World, MovesATeleportedGraspNoFasterThanAllowed) {
  // A jump of 10 m: the note says so, the node goes 10 mm a step, and nothing tears.
  World world(test::sheet_model(small_sheet()), settings(), {}, {grasp_nodes("g", "towel", {0})});
  const Reply reply = world.apply(command::MoveGrasp{"g", at(10, 0, 0), 0.0});
  EXPECT_TRUE(reply.status.ok());
  EXPECT_TRUE(contains(reply.note, "rate-limited to 1 m/s")) << reply.note;
  for (int i = 0; i < 50; ++i) {
    const Vec3 before = world.state().x.col(0);
    ASSERT_TRUE(world.step().ok);
    EXPECT_LE((world.state().x.col(0) - before).norm(), 0.01 + 1e-9);
  }
  const Snapshot s = world.snapshot();
  EXPECT_TRUE(s.grasps[0].speed_limited);
  EXPECT_LT(s.bodies[0].max_strain, 0.5);
}

TEST(World, SetsABodyStateExactly) {
  const auto world = busy_world();
  const State before = world->state();
  Nodes x = before.x, v = before.v;
  x.col(40) += Vec3(0.001, 0, 0.002);
  v.col(40) = Vec3(0.1, 0, 0);
  ASSERT_TRUE(world->apply(command::SetBodyState{"towel", x, v}).status.ok());
  EXPECT_EQ(world->state().x, x);
  EXPECT_EQ(world->state().v, v);
  // A held node that is put elsewhere is held there.
  x.col(0) += Vec3(0, 0, 0.3);
  EXPECT_FALSE(world->apply(command::SetBodyState{"towel", x, v}).note.empty());
  world->step();
  EXPECT_NEAR((world->state().x.col(0) - x.col(0)).norm(), 0.0, 1e-12);
}

TEST(World, CutsExplicitStepsIntoStableParts) {
  // Symplectic Euler on k = 1000 N/m, m = 0.1 kg pairs: omega_max = sqrt(2 k / m) = 141 rad/s, limit 2 / omega = 14 ms;
  // a step of 100 ms needs ceil(100 / (0.9 * 14.1)) = 8 parts.
  Nodes x = Nodes::Zero(3, 2);
  x(0, 1) = 0.1;
  const auto build = [&](double damping) {
    auto model = test::points_model(x, 0.1, Vec3::Zero());
    SpringLink link;
    link.a = 0;
    link.b = 1;
    link.rest_length = 0.1;
    link.stiffness = 1000.0;
    link.damping = damping;
    model->energies.push_back(make_springs("stretch springs", {link}, 0));
    model->initial.v(0, 1) = 0.1;
    return model;
  };
  World world(build(0.0), settings("symplectic_euler", 0.1), {}, {});
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(world.step().ok);
  const Snapshot s = world.snapshot();
  EXPECT_EQ(s.substeps, 8);
  ASSERT_EQ(s.warnings.size(), 1u);
  EXPECT_TRUE(contains(s.warnings[0], "8 substeps")) << s.warnings[0];
  // v0 / omega of amplitude for ever.
  EXPECT_LT(std::abs(s.x(0, 1) - s.x(0, 0) - 0.1), 0.1 / 141.0 * 2.0);

  // Damping c = 20 N s/m makes the limit (2 / omega)(sqrt(1 + zeta^2) - zeta), zeta = c omega / (2 k) = 1.41: 4.5 ms.
  World damped(build(20.0), settings("symplectic_euler", 0.1), {}, {});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(damped.step().ok);
  EXPECT_EQ(damped.snapshot().substeps, 25);
  EXPECT_LT(damped.snapshot().bodies[0].kinetic_energy, 0.1 * 0.1 * 0.1);

  World teaching(build(0.0), settings("explicit_euler", 0.005), {}, {});
  ASSERT_TRUE(teaching.step().ok);
  ASSERT_EQ(teaching.snapshot().warnings.size(), 1u);
  EXPECT_TRUE(contains(teaching.snapshot().warnings[0], "unstable"));
}

TEST(World, BillsOnlyWhatItHas) {
  const auto parts = [](const World& world) {
    std::string names;
    for (const BillItem& item : world.bill()) names += item.part + ";";
    return names;
  };
  World bare(test::points_model(Nodes::Zero(3, 3), 0.1, Vec3::Zero()), settings("symplectic_euler"), {}, {});
  EXPECT_EQ(parts(bare), "symplectic_euler;");

  const auto world = busy_world();
  EXPECT_EQ(parts(*world),
            "stretch springs;shear springs;bend springs;gravity;linear solver;implicit_euler;contact;grasps;");
  double share = 0.0;
  for (const BillItem& item : world->bill()) {
    EXPECT_GE(item.share, 0.0);
    share += item.share;
  }
  EXPECT_NEAR(share, 1.0, 1e-9);
  world->apply(command::RemoveCollider{"table"});
  world->apply(command::Release{"left"});
  EXPECT_EQ(parts(*world), "stretch springs;shear springs;bend springs;gravity;linear solver;implicit_euler;");
}

}  // namespace
}  // namespace deformable_sim
