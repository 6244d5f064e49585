// Two fingers close on the hem of a hanging cloth and lift it, by friction alone.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim::test {
namespace {

constexpr double kOpen = 0.0115, kShut = 0.0105;  // m, of a finger's middle; half a finger and the thickness are 0.011

std::string scene(const std::string& step) {
  return "bodies:\n"
         "  - cloth: {name: towel, size: [0.3, 0.3], cells: [15, 15], friction: 0.8, contact_radius: 0.001,\n"
         "      contact_points: faces, pose: {position: [0, 0, 0], rpy: [1.5707963267948966, 0, 0]},\n"
         "      material: {areal_density: 0.2, thickness: 0.001, youngs_modulus: 1.0e5, damping: 0.003,\n"
         "                 bending_rigidity: [1.0e-5, 1.0e-5]}, bending: quadratic}\n"
         "air: {damping: 3}\n"
         "colliders:\n"
         "  - box: {name: left, size: [0.06, 0.02, 0.03], friction: 0.8, pose: {position: [0, -0.0115, 0.14]}}\n"
         "  - box: {name: right, size: [0.06, 0.02, 0.03], friction: 0.8, pose: {position: [0, 0.0115, 0.14]}}\n"
         "step: {" +
         step + "}\n";
}

class PinchGrasp : public testing::TestWithParam<std::string> {
 protected:
  void move(World* world, double opening, double height, double duration) const {
    for (const double side : {-1.0, 1.0}) {
      Pose pose = Pose::Identity();
      pose.translation() = Vec3(0, side * opening, height);
      const std::string finger = side < 0.0 ? "left" : "right";
      ASSERT_TRUE(world->apply(command::MoveCollider{finger, pose, duration}).status.ok());
    }
  }
  void run(World* world, double seconds) const {
    for (long k = 0; k < std::lround(seconds / world->settings().dt); ++k) ASSERT_TRUE(world->step().ok);
  }
};

INSTANTIATE_TEST_SUITE_P(Schemes, PinchGrasp,
                         testing::Values("implicit_euler, linear_solver: multigrid", "bdf2, linear_solver: multigrid",
                                         "tr_bdf2, linear_solver: multigrid", "substepped_verlet"),
                         [](const auto& info) { return info.param.substr(0, info.param.find(',')); });

TEST_P(PinchGrasp, LiftsTheClothAndKeepsIt) {
  // Lifted by 0.2 m: so are the pinched nodes, within the millimetre that the fingers close by; then they stay.
  const auto world = build_world(load_scene_text(scene("dt: 0.005, integrator: " + GetParam()), "pinch.yaml"));
  move(world.get(), kShut, 0.14, 0.02);
  run(world.get(), 0.5);
  int pinched = 0;
  world->state().x.row(2).maxCoeff(&pinched);
  const double before = world->state().x(2, pinched);
  move(world.get(), kShut, 0.34, 1.0);
  run(world.get(), 3.0);
  const double lifted = world->state().x(2, pinched);
  EXPECT_NEAR(lifted - before, 0.2, 1e-3);
  run(world.get(), 4.0);
  EXPECT_NEAR(world->state().x(2, pinched), lifted, 4.0 * 1e-5);
  EXPECT_EQ(world->snapshot().grasps.size(), 0u);

  move(world.get(), kOpen, 0.34, 0.02);
  run(world.get(), 0.5);
  EXPECT_LT(world->state().x(2, pinched), lifted - 0.5);
}

}  // namespace
}  // namespace deformable_sim::test
