// Stages of sheets on grids by multigrid: the same solution as the generic stage with a sparse factorisation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kCloth = "name: a, size: [0.6, 0.5], cells: [12, 9], pose: {position: [0, 0, 0.4]}";
const std::string kMaterial =
    "areal_density: 0.2, thickness: 0.001, youngs_modulus: 3.0e4, bending_rigidity: [2e-4, 2e-4]";

struct Case {
  const char* name;
  std::string bodies;
  std::string rest;  // colliders, grasps, air
};

std::string cloth(const std::string& material, const std::string& keys) {
  return "  - cloth: {" + kCloth + ", material: {" + kMaterial + material + "}" + keys + "}\n";
}

const std::string kPins = ", pins: [corner_2, corner_3]", kQuadratic = ", bending: quadratic";
const std::string kBall =
    "colliders:\n  - sphere: {name: ball, radius: 0.15, pose: {position: [0.02, 0.01, 0.244]}, friction: 0}\n";

std::vector<Case> cases() {
  return {
      {"Hanging", cloth("", kPins + kQuadratic), ""},
      {"Damped", cloth(", damping: 0.01, bending_damping: 0.02", kPins + kQuadratic), "air: {damping: 2}\n"},
      {"Flexion", cloth(", damping: 0.003", kPins), ""},
      {"Grasped", cloth("", kQuadratic),
       "grasps:\n"
       "  - {name: g, body: a, select: {feature: edge_2}, stiffness: 20}\n"
       "  - {name: h, body: a, select: {radius: 0.1, center: [0.3, -0.25, 0.4]}}\n"},
      {"Draped", cloth(", damping: 0.002", kQuadratic), kBall},
      {"DrapedAtFaces", cloth("", ", contact_points: faces"), kBall},
      {"Limited", cloth("", kPins + ", strain_limit: 0.02"), ""},
      {"TwoSheets",
       cloth("", kPins + kQuadratic) +
           "  - cloth: {name: b, size: [0.3, 0.3], cells: [5, 5], pose: {position: [1, 0, 1]},"
           " material: {" +
           kMaterial + "}}\n",
       ""},
  };
}

std::unique_ptr<World> build(const Case& c, const std::string& step) {
  return build_world(load_scene_text("bodies:\n" + c.bodies + c.rest + "step: {" + step + "}\n", "s.yaml"));
}

class Multigrid : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Schemes, Multigrid, testing::Values("implicit_euler", "bdf2", "tr_bdf2"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(Multigrid, ConvergesToTheSolutionOfTheSparseFactorisation) {
  // M a = f(x, v) + contacts has one solution near the start: 1e-8 m after 20 steps, each solved to 1e-8 m/s^2.
  for (const Case& c : cases()) {
    const std::string common =
        "dt: 0.01, newton_iterations: 200, tolerance: 1.0e-8, integrator: " + std::string(GetParam());
    const auto expected = build(c, common + ", linear_solver: direct");
    const auto found = build(c, common + ", linear_solver: multigrid, linear_tolerance: 1.0e-4");
    int reached = 0;
    for (int k = 0; k < 20; ++k) {
      const StepOutcome a = expected->step(), b = found->step();
      ASSERT_TRUE(a.ok && b.ok) << c.name;
      if (b.report.converged) ++reached;
      EXPECT_TRUE(!a.report.converged || b.report.converged) << c.name << ", step " << k << ", " << b.report.residual;
    }
    EXPECT_GT(reached, 0) << c.name;
    EXPECT_LT((expected->state().x - found->state().x).cwiseAbs().maxCoeff(), 1e-8) << c.name;
    EXPECT_LT((expected->state().v - found->state().v).cwiseAbs().maxCoeff(), 1e-5) << c.name;
    const Snapshot a = expected->snapshot(), b = found->snapshot();
    for (size_t k = 0; k < a.grasps.size(); ++k)
      EXPECT_LT((a.grasps[k].force - b.grasps[k].force).norm(), 1e-5) << c.name;
    ASSERT_EQ(a.contact_force.size(), b.contact_force.size()) << c.name;
    if (a.contact_force.size() == 0) continue;
    EXPECT_LT((a.contact_force - b.contact_force).cwiseAbs().maxCoeff(), 1e-4f) << c.name;
  }
}

TEST_P(Multigrid, StaysAtRestWhereTheSparseFactorisationDoes) {
  // A sheet that rests moves no further, however few iterations a step has: r(x) = 0 at the start of every step.
  const Case c{"rest", cloth("", kPins + kQuadratic), "air: {damping: 4}\n"};
  const auto settled = build(c, "dt: 0.05, newton_iterations: 100, tolerance: 1.0e-9, integrator: implicit_euler");
  for (int k = 0; k < 800; ++k) settled->step();
  const auto world = build(c,
                           "dt: 0.02, newton_iterations: 1, tolerance: 1.0e-9, linear_iterations: 1, "
                           "linear_solver: multigrid, integrator: " +
                               std::string(GetParam()));
  const Nodes x = settled->state().x;
  world->apply(command::SetBodyState{"a", x, Nodes::Zero(3, x.cols())});
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world->step().ok);
  EXPECT_LT((world->state().x - x).cwiseAbs().maxCoeff(), 1e-7);
}

TEST_P(Multigrid, HangsWithinItsStrainLimitsAfterFewIterations) {
  // A soft sheet falls into its limits and comes to rest below its pins, every thread within 10 % of its length.
  const std::string text =
      "bodies:\n  - cloth: {name: a, size: [0.4, 0.5], cells: [20, 25], strain_limit: 0.1, pins: [corner_2, "
      "corner_3],\n"
      "            pose: {position: [0, 0, 1], rpy: [1.5708, 0, 0]},\n"
      "            material: {areal_density: 0.3, thickness: 0.002, youngs_modulus: 5000}}\n"
      "step: {dt: 0.01, newton_iterations: 4, linear_solver: multigrid, integrator: " +
      std::string(GetParam()) + "}\n";
  const auto world = build_world(load_scene_text(text, "s.yaml"));
  for (int k = 0; k < 200; ++k) ASSERT_TRUE(world->step().ok);
  const Snapshot now = world->snapshot();
  EXPECT_LT(now.bodies[0].max_strain, 0.1 + 1e-5);
  EXPECT_NEAR(now.x.row(2).mean(), 0.96, 0.01);
  EXPECT_LT(now.v.colwise().norm().maxCoeff(), 1.0);
}

TEST(MultigridStage, GoesOnWithARoughStageInsteadOfCuttingTheStep) {
  // One Newton step at 1/120 s leaves a stiff sheet that begins to hang above 35 m/s2 now and then. Up to four more are
  // taken, and no step is cut, as residuals above 100 m/s2 would have it.
  const std::string text =
      "bodies:\n  - cloth: {name: a, size: [1, 1], cells: [30, 30], pins: [corner_2, corner_3], bending: quadratic,\n"
      "            material: {areal_density: 0.2, membrane_stiffness: 1.0e+4, bending_rigidity: 1.0e-5, damping: 0,\n"
      "                       bending_damping: 0.01}}\n"
      "air: {damping: 3}\n"
      "step: {dt: 0.0083333, newton_iterations: 1, linear_iterations: 3, linear_solver: multigrid, integrator: bdf2}\n";
  const auto world = build_world(load_scene_text(text, "s.yaml"));
  int most = 0;
  for (int k = 0; k < 60; ++k) {
    const StepOutcome outcome = world->step();
    ASSERT_TRUE(outcome.ok);
    if (k > 0) most = std::max(most, outcome.report.newton_iterations);  // the first step is TR-BDF2's: two stages
    EXPECT_LT(outcome.report.residual, 100.0) << k;
    EXPECT_EQ(world->snapshot().substeps, 1) << k;
  }
  EXPECT_GT(most, 1);
  EXPECT_LE(most, 5);
}

TEST(MultigridStage, SlidesAsFrictionLetsIt) {
  // On a slope of 20 degrees: at rest for mu > tan(20 deg) = 0.364, else a = g (sin theta - mu cos theta).
  const double theta = 20.0 / 57.29577951308232, g = 9.81;
  for (const double mu : {0.6, 0.2}) {
    const std::string text =
        "bodies:\n  - cloth: {name: a, size: [0.2, 0.2], cells: [4, 4], friction: " + std::to_string(mu) +
        ", contact_radius: 0.001, pose: {position: [0, 0, 0.0010643], rpy: [0, 0.3490658503988659, 0]}}\n"
        "colliders:\n  - plane: {name: slope, friction: " +
        std::to_string(mu) +
        ", pose: {position: [0, 0, 0], rpy: [0, 0.3490658503988659, 0]}}\n"
        "step: {dt: 0.002, integrator: bdf2, linear_solver: multigrid, newton_iterations: 20, tolerance: 1.0e-4}\n";
    const auto world = build_world(load_scene_text(text, "s.yaml"));
    for (int k = 0; k < 100; ++k) world->step();
    const double speed = world->state().v.colwise().norm().mean(), t = world->time();
    const double expected = mu > std::tan(theta) ? 0.0 : g * (std::sin(theta) - mu * std::cos(theta)) * t;
    EXPECT_NEAR(speed, expected, 0.02 * g * std::sin(theta) * t) << mu;
  }
}

TEST(MultigridStage, RepeatsItselfBitByBitWhateverCameBefore) {
  // What a solver keeps from step to step does not change what comes out.
  for (const Case& c : cases()) {
    const std::string step =
        "dt: 0.01, integrator: bdf2, linear_solver: multigrid, newton_iterations: 2, linear_iterations: 3";
    const auto fresh = build(c, step), used = build(c, step);
    for (int k = 0; k < 12; ++k) used->step();
    used->apply(command::Reset{});
    for (int k = 0; k < 12; ++k) {
      fresh->step();
      used->step();
    }
    EXPECT_EQ(fresh->state().x, used->state().x) << c.name;
  }
}

}  // namespace
}  // namespace deformable_sim
