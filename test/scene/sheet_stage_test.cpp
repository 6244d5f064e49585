// Stages of sheets on grids by multigrid: the same solution as the generic stage with a sparse factorisation.
#include <gtest/gtest.h>

#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kCloth = "name: a, size: [0.6, 0.5], cells: [12, 9], pose: {position: [0, 0, 0.4]}";
const std::string kMaterial = "areal_density: 0.2, thickness: 0.001, youngs_modulus: 3.0e4, bending_rigidity: [2e-4, 2e-4]";

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
       cloth("", kPins + kQuadratic) + "  - cloth: {name: b, size: [0.3, 0.3], cells: [5, 5], pose: {position: [1, 0, 1]},"
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
    const std::string common = "dt: 0.01, newton_iterations: 200, tolerance: 1.0e-8, integrator: " + std::string(GetParam());
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
    for (size_t k = 0; k < a.grasps.size(); ++k) EXPECT_LT((a.grasps[k].force - b.grasps[k].force).norm(), 1e-5) << c.name;
    ASSERT_EQ(a.contact_force.size(), b.contact_force.size()) << c.name;
    if (a.contact_force.size() > 0) EXPECT_LT((a.contact_force - b.contact_force).cwiseAbs().maxCoeff(), 1e-4f) << c.name;
  }
}

}  // namespace
}  // namespace deformable_sim
