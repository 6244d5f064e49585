// F14: a stiff ball on a soft mat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/ball_file.h"
#include "support/crossings.h"
#include "support/system.h"
#include "support/verification.h"
#include "support/watched_run.h"

namespace deformable_sim::test {
namespace {

constexpr double kRadius = 0.05, kMat = 0.1;  // m

/// `step`: its keys. The ball is `aside` (m) of the middle of the mat.
std::unique_ptr<World> ball_above_mat(const std::string& step, double aside) {
  return build_world(
      load_scene_text("step: {" + step +
                          "}\n"
                          "colliders:\n  - plane: {name: floor}\n"
                          "bodies:\n"
                          "  - soft: {name: mat, touches: others, box: {size: [0.4, 0.4, 0.1], cells: [8, 8, 2]}, "
                          "element: tetrahedron, "
                          "contact_radius: 0.001, pose: {position: [0, 0, 0.051]}, "
                          "material: {youngs_modulus: 1.0e+6, poissons_ratio: 0.45, density: 1000}}\n"
                          "  - soft: {name: ball, touches: others, mesh: " +
                          ball_file(kRadius, 4) + ", element: tetrahedron, contact_radius: 0.001, pose: {position: [" +
                          std::to_string(aside) +
                          ", 0, 0.165]}, material: {youngs_modulus: 1.0e+8, poissons_ratio: 0.3, density: 2000}}\n",
                      "test"));
}

double lowest_of(const World& world, const Body& body) {
  return world.state().x.middleCols(body.first_node, body.node_count).row(2).minCoeff();
}

/// Steps so long; what came from nowhere over what the ball's fall of a centimetre sets free.
double created(World* world, double seconds) {
  const Model& model = world->model();
  while (world->time() < seconds - 1e-9) {
    const StepOutcome outcome = world->step();
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_TRUE(world->state().finite());
    expect_reported(*world, outcome.report);
    EXPECT_EQ(count_crossings(model, world->state().x), 0) << world->time();
  }
  const Body& ball = model.bodies[1];
  const double mass = model.mass.segment(ball.first_node, ball.node_count).sum();
  return world->snapshot().energy_created / (mass * kGravity * 0.01);
}

TEST(StiffOnSoft, BallLiesOnTheMat) {
  // 2000 kg/m^3 and 1e8 Pa on 1000 kg/m^3 and 1e6 Pa. Nothing crosses at any time, no energy is made, and in the end
  // all is at rest and the floor carries both, 0.5 %. Newton's method needs more than the default four iterations where
  // one body is so stiff: steps cut short leave residuals that drive it, and say so.
  const auto world = ball_above_mat("dt: 0.01, integrator: implicit_euler, newton_iterations: 30", 0.0);
  check("F14", "energy that no work explains, over that of the fall", created(world.get(), 1.0), 0.0, 1e-6,
        Tolerance::kAbsolute);
  check("F14", "largest speed of a ball on a mat, m/s", world->state().v.colwise().norm().maxCoeff(), 0.0, 1e-3,
        Tolerance::kAbsolute);
  double carried = 0.0;
  for (const ContactReport& c : world->contact_reports())
    if (c.collider >= 0) carried += c.force.z();
  check("F14", "force of the floor over the weight of ball and mat", carried / (world->model().mass.sum() * kGravity),
        1.0, 0.005);
  // On the mat, pressed into it by less than a tenth of its radius.
  EXPECT_LT(lowest_of(*world, world->model().bodies[1]), kMat + 0.003 + 1e-4);
  EXPECT_GT(lowest_of(*world, world->model().bodies[1]), kMat - 0.1 * kRadius);
}

TEST(StiffOnSoft, BallIsNotThrownByStepsThatAreNotSolved) {
  // A scheme for softer scenes, one Newton iteration a step, does not solve the impact. Such a step that also makes
  // energy is no step: implicit Euler with time makes it. Thrown up to 32 m before that, by 736 J. Nothing like it was
  // measured in contact: `auto` takes no such scheme.
  for (const std::string scheme : {"", ", integrator: tr_bdf2, newton_iterations: 1, linear_solver: multigrid"}) {
    SCOPED_TRACE(scheme);
    const auto world = ball_above_mat("dt: 0.01" + scheme, 0.003);
    EXPECT_EQ(world->settings().integrator, scheme.empty() ? "implicit_euler" : "tr_bdf2");
    check("F14", "energy that no work explains, over that of the fall", created(world.get(), 0.3), 0.0, 0.1,
          Tolerance::kAbsolute);
    EXPECT_LT(world->state().x.row(2).maxCoeff(), 0.3);
  }
}

}  // namespace
}  // namespace deformable_sim::test
