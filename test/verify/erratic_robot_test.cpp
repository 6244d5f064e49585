// Colliders that move as robots and their drivers do when something is wrong: jumps, gaps, links inside the cloth,
// jaws that close on a corner, a table that comes up through a towel.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim::test {
namespace {

/// Half a millimetre: what a step may leave behind before it is made again in parts (doc/theory/contact.md, 3).
constexpr double kTolerance = 0.0005;

class ErraticRobot : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<World> build(const std::string& pins, const std::string& colliders, double height = 0.0) const {
    return build_world(load_scene_text(
        "bodies:\n"
        "  - cloth: {name: towel, size: [0.3, 0.3], cells: [15, 15], contact_radius: 0.001, contact_points: faces,\n"
        "      pose: {position: [0, 0, " +
            std::to_string(height) + "]}, pins: [" + pins +
            "],\n"
            "      material: {areal_density: 0.2, thickness: 0.001, youngs_modulus: 1.0e5, damping: 0.003,\n"
            "                 bending_rigidity: [1.0e-5, 1.0e-5]}, bending: quadratic}\n"
            "air: {damping: 3}\n"
            "colliders:\n" +
            colliders + "step: {" + GetParam() + "}\n",
        "erratic.yaml"));
  }

  void step(World* world, const std::string& when) {
    const StepOutcome outcome = world->step();
    ASSERT_TRUE(outcome.ok) << when << ": " << outcome.message;
    ASSERT_TRUE(world->state().finite()) << when;
    const Snapshot now = world->snapshot();
    deepest_ = std::max(deepest_, now.max_penetration);
    deepest_anywhere_ =
        std::max(deepest_anywhere_, measure_penetration(world->model(), now.colliders, world->state().x));
    largest_strain_ = std::max(largest_strain_, now.bodies[0].max_strain);
  }
  void run(World* world, double seconds, const std::string& when) {
    for (long k = 0; k < std::lround(seconds / world->settings().dt); ++k) {
      step(world, when);
      if (HasFatalFailure()) return;
    }
  }
  static void move(World* world, const std::string& name, const Vec3& to, double duration) {
    Pose pose = Pose::Identity();
    pose.translation() = to;
    ASSERT_TRUE(world->apply(command::MoveCollider{name, pose, duration}).status.ok());
  }

  void TearDown() override {
    RecordProperty("deepest_mm", std::to_string(1e3 * deepest_));
    RecordProperty("deepest_anywhere_mm", std::to_string(1e3 * deepest_anywhere_));
    RecordProperty("largest_strain", std::to_string(largest_strain_));
  }

  double deepest_ = 0.0, deepest_anywhere_ = 0.0, largest_strain_ = 0.0;
};

INSTANTIATE_TEST_SUITE_P(Schemes, ErraticRobot,
                         testing::Values("dt: 0.005, integrator: implicit_euler, linear_solver: multigrid",
                                         "dt: 0.005, integrator: bdf2, linear_solver: multigrid",
                                         "dt: 0.005, integrator: tr_bdf2, linear_solver: multigrid",
                                         "dt: 0.005, integrator: substepped_verlet"),
                         [](const auto& info) {
                           const std::string text = info.param.substr(info.param.find("integrator: ") + 12);
                           return text.substr(0, text.find(','));
                         });

TEST_P(ErraticRobot, FramesThatJumpByAMetreThrowNothing) {
  // A ball under a sheet hung from four corners is told to be a metre up, down and aside, then there and back in every
  // step: it goes at 5 m/s at most, through the sheet's place, and the sheet gives way or is pushed, whole.
  const auto world = build("corner_0, corner_1, corner_2, corner_3",
                           "  - sphere: {name: fist, radius: 0.05, pose: {position: [0, 0, -0.12]}}\n");
  run(world.get(), 0.3, "before");
  move(world.get(), "fist", Vec3(0.3, 0, 0.88), 0.0);
  run(world.get(), 0.1, "up and aside");
  move(world.get(), "fist", Vec3(0, 0, -0.12), 0.0);
  run(world.get(), 0.5, "back");
  std::mt19937 random(51);
  std::uniform_real_distribution<double> in(-0.02, 0.02);
  for (int k = 0; k < 50; ++k) {
    move(world.get(), "fist", Vec3(in(random), in(random), -0.09 + in(random)), 0.02);
    step(world.get(), "shaking");
    if (HasFatalFailure()) return;
  }
  EXPECT_LT(deepest_, kTolerance);
}

TEST_P(ErraticRobot, FramesWithGapsThrowNothing) {
  // A plate slides under a lying sheet; its pose arrives after 20 ms to 300 ms, and in between it stands.
  const auto world =
      build("", "  - box: {name: plate, size: [0.5, 0.5, 0.02], pose: {position: [0, 0, -0.01]}}\n", 0.002);
  run(world.get(), 0.2, "before");
  std::mt19937 random(52);
  double x = 0.0;
  for (int k = 0; k < 12; ++k) {
    const double gap = k % 4 == 3 ? 0.3 : 0.02;
    x += (k / 4 % 2 == 0 ? 0.3 : -0.3) * gap;
    move(world.get(), "plate", Vec3(x, 0, -0.01), 0.02);
    run(world.get(), gap, "moving");
    if (HasFatalFailure()) return;
  }
  EXPECT_LT(deepest_, kTolerance);
  EXPECT_GT(world->state().x.row(2).minCoeff(), 0.0);
}

TEST_P(ErraticRobot, LinksThatStartInsideTheClothLetItOut) {
  // A box of 60 mm appears with a hanging sheet a third of the way through it, a ball beside it: within half a second
  // nothing of the sheet is inside. It may hang over them stretched: each node goes out where it is nearest.
  const auto world =
      build("corner_0, corner_1", "  - box: {name: far, size: [0.1, 0.1, 0.1], pose: {position: [9, 0, 0]}}\n");
  run(world.get(), 0.3, "before");
  const Nodes& x = world->state().x;
  const Vec3 normal = Vec3(x.col(121) - x.col(119)).cross(Vec3(x.col(136) - x.col(104))).normalized();
  Collider link;
  link.name = "hand";
  link.shapes.resize(2);
  link.shapes[0].size = Vec3(0.06, 0.06, 0.06);
  link.shapes[1].type = Shape::Type::kSphere;
  link.shapes[1].size = Vec3(0.03, 0, 0);
  link.shapes[1].collider_from_shape.translation() = Vec3(0.06, 0.0, 0.0);
  link.world_from_collider.linear() = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), normal).toRotationMatrix();
  link.world_from_collider.translation() = Vec3(x.col(120)) - 0.01 * normal;
  ASSERT_TRUE(world->apply(command::AddCollider{link}).status.ok());
  run(world.get(), 0.5, "coming out");
  deepest_ = deepest_anywhere_ = 0.0;
  run(world.get(), 0.5, "out");
  EXPECT_LT(deepest_, kTolerance);
  EXPECT_EQ(deepest_anywhere_, 0.0);
}

TEST_P(ErraticRobot, JawsThatCloseOnACornerKeepIt) {
  // Two plates close on a free corner to half the cloth's thickness, shake it, and open.
  const auto world =
      build("corner_2, corner_3",
            "  - box: {name: left, size: [0.05, 0.05, 0.02], pose: {position: [-0.15, -0.15, -0.03]}}\n"
            "  - box: {name: right, size: [0.05, 0.05, 0.02], pose: {position: [-0.15, -0.15, 0.03]}}\n");
  const auto jaws = [&](double opening, const Vec3& at, double duration) {
    move(world.get(), "left", at - Vec3(0, 0, 0.01 + opening), duration);
    move(world.get(), "right", at + Vec3(0, 0, 0.01 + opening), duration);
  };
  jaws(0.0005, Vec3(-0.15, -0.15, 0), 0.05);
  run(world.get(), 0.2, "closing");
  std::mt19937 random(53);
  std::uniform_real_distribution<double> in(-0.01, 0.01);
  for (int k = 0; k < 20; ++k) {
    jaws(0.0005, Vec3(-0.15 + in(random), -0.15 + in(random), in(random)), 0.05);
    run(world.get(), 0.05, "shaking");
    if (HasFatalFailure()) return;
  }
  const Vec3 corner = world->state().x.col(0);
  EXPECT_LT((corner - Vec3(-0.15, -0.15, 0)).norm(), 0.03);
  jaws(0.02, Vec3(-0.15, -0.15, 0), 0.05);
  run(world.get(), 0.5, "open");
  // Jaws leave the cloth 0.5 mm on each side where it keeps 1 mm, never less than none.
  EXPECT_LT(deepest_, kTolerance);
}

TEST_P(ErraticRobot, ATableThatComesUpThroughATowelLiftsIt) {
  // A plate of 20 mm at 1 and 5 m/s from below a falling sheet: the sheet lies on it at the end.
  for (const double speed : {1.0, 5.0}) {
    const auto world = build("", "  - box: {name: table, size: [0.6, 0.6, 0.02], pose: {position: [0, 0, -0.3]}}\n");
    move(world.get(), "table", Vec3(0, 0, 0.4), 0.7 / speed);
    run(world.get(), 0.7 / speed, "rising at " + std::to_string(speed));
    if (HasFatalFailure()) return;
    EXPECT_GT(world->state().x.row(2).minCoeff(), world->snapshot().colliders[0].world_from_collider.translation().z());
    run(world.get(), 1.5, "after " + std::to_string(speed));
    EXPECT_LT(deepest_, kTolerance) << speed;
  }
}

}  // namespace
}  // namespace deformable_sim::test
