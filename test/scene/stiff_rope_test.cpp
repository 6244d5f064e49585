// Real ropes by name move as they should with the settings a scene has when it says nothing.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

/// A metre of rope, horizontal and held at one end, with other bodies beside it. `step`: lines of that map.
std::unique_ptr<World> swinging_rope(const std::string& step, const std::string& keys, const std::string& others = "") {
  return build_world(
      load_scene_text("step: {" + step +
                          "}\nbodies:\n  - rope: {name: rope, pose: {position: [0, 0, 1]}, length: 1, pins: "
                          "[end_0], " +
                          keys + "}\n" + others,
                      "s.yaml"));
}

/// Largest distance (m) of the free end to that of the same rope solved to round-off.
double error_of_end(World* world, World* exact, int steps) {
  const Body& body = world->model().bodies[0];
  const int end = body.first_node + body.node_count - 1;
  double error = 0.0;
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(world->step().ok && exact->step().ok);
    error = std::max(error, (world->state().x.col(end) - exact->state().x.col(end)).norm());
  }
  return error;
}

std::string solver_of(const World& world) {
  for (const BillItem& item : world.bill())
    if (item.part == "linear solver") return item.detail.substr(0, item.detail.find(','));
  return "";
}

TEST(StiffRope, ByNameSwingsAsTheSchemeSays) {
  // M a = f to 0.02 m/s^2 in every step: the end stays within 1 mm of the exact solution of the same scheme. Four
  // Newton iterations with conjugate gradients leave it 0.1 to 1 m behind.
  for (const std::string material : {"steel_cable", "nylon_rope", "kevlar_49_rope", "hmpe_rope", "steel_wire_1mm"}) {
    for (const std::string model : {"springs", "rod"}) {
      const std::string keys = "segments: 20, model: " + model + ", material: " + material;
      const auto world = swinging_rope("solver: manual, dt: 0.01", keys);
      const auto exact =
          swinging_rope("dt: 0.01, linear_solver: direct, newton_iterations: 200, tolerance: 1e-3", keys);
      EXPECT_LT(error_of_end(world.get(), exact.get(), 50), 1e-3) << model << ", " << material;
      EXPECT_LT(world->snapshot().report.residual, 0.02) << model << ", " << material;
      for (const std::string& warning : world->snapshot().warnings)
        EXPECT_EQ(warning.find("inaccurate"), std::string::npos) << warning;
    }
  }
}

TEST(StiffRope, ByNameIsSolvedToItsToleranceByWhatIsChosenForIt) {
  for (const std::string material : {"steel_cable", "nylon_rope", "kevlar_49_rope", "hmpe_rope", "steel_wire_1mm"}) {
    for (const std::string model : {"springs", "rod"}) {
      const auto world = swinging_rope("solver: auto", "segments: 20, model: " + model + ", material: " + material);
      while (world->time() < 0.5) {
        ASSERT_TRUE(world->step().ok);
        EXPECT_LT(world->snapshot().report.residual, 0.02)
            << model << ", " << material << ": " << world->settings().chosen;
      }
    }
  }
}

TEST(StiffRope, ByNameStretchesByItsWeight) {
  // The segment below the grip of a hanging rope carries all but half a node: e = m g (N - 1/2) / N / EA.
  // steel_cable: EA = 0.4 * 26e6 m^2/s^2 * 0.05 kg/m = 5.2e5 N; what air and time leave of the swing: 1 %.
  const auto world = swinging_rope("dt: 0.01", "segments: 20, material: steel_cable", "gravity: [9.81, 0, 0]\n");
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(world->step().ok);
  const double expected = 0.05 * 9.81 * (20 - 0.5) / 20 / 5.2e5;
  EXPECT_NEAR(world->snapshot().bodies[0].max_strain, expected, 0.01 * expected);
}

TEST(StiffRope, IsRecognisedAndOverruled) {
  const std::string cable = "segments: 20, material: steel_cable",
                    soft = "segments: 20, material: {youngs_modulus: 1e6}";
  const std::string cloth = "  - cloth: {name: c, cells: [4, 4]}\n";
  EXPECT_EQ(solver_of(*swinging_rope("solver: manual, dt: 0.01", cable)), "banded");
  EXPECT_EQ(solver_of(*swinging_rope("solver: manual, dt: 0.01", soft)), "banded") << "ropes alone";
  EXPECT_EQ(solver_of(*swinging_rope("solver: manual, dt: 0.01", soft, cloth)), "banded") << "beside other bodies";
  EXPECT_EQ(solver_of(*swinging_rope("dt: 0.01, linear_solver: cg", cable)), "conjugate gradient");
  EXPECT_EQ(swinging_rope("solver: manual, dt: 0.01", cable)->settings().solver.newton_iterations, 100);
  EXPECT_EQ(swinging_rope("dt: 0.01, newton_iterations: 7", cable)->settings().solver.newton_iterations, 7);
  EXPECT_EQ(swinging_rope("solver: manual, dt: 0.01", soft, cloth)->settings().solver.newton_iterations, 4);
  EXPECT_EQ(swinging_rope("solver: manual, dt: 0.01", "segments: 20, material: {axial_stiffness: 5.2e5}")
                ->settings()
                .solver.newton_iterations,
            100)
      << "stiff without a name";
}

TEST(StiffRope, IsNotDraggedDownByABodyBeside) {
  // The same bits of the rope, to the tolerance of Newton's method, whether or not a sheet hangs far away.
  const std::string cable = "segments: 20, material: steel_cable";
  const auto alone = swinging_rope("solver: manual, dt: 0.01", cable);
  const auto beside =
      swinging_rope("solver: manual, dt: 0.01", cable,
                    "  - cloth: {name: c, pose: {position: [5, 0, 1]}, cells: [8, 8], pins: [corner_0]}\n");
  EXPECT_LT(error_of_end(beside.get(), alone.get(), 50), 1e-4);
}

}  // namespace
}  // namespace deformable_sim
