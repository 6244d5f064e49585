// Stages of scenes that are no grids by multigrid on aggregates: the same solution as with a sparse factorisation.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/crooked_sheet.h"

namespace deformable_sim {
namespace {

struct Case {
  const char* name;
  std::string text;  // bodies, colliders, grasps, air
};

/// A crooked sheet of 0.6 m and 144 nodes as a file.
std::string mesh_file() {
  const std::string path = testing::TempDir() + "crooked_sheet.obj";
  const TriangleMesh mesh = test::crooked_sheet(12);
  std::ofstream file(path);
  file.precision(9);
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) {
    file << "v " << 0.6 * mesh.rest(0, i) - 0.3 << ' ' << 0.6 * mesh.rest(1, i) - 0.3 << " 0\n";
  }
  for (const auto& t : mesh.triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return path;
}

std::string cloth(const std::string& keys) {
  return "bodies:\n  - cloth: {name: a, mesh: " + mesh_file() +
         ", pose: {position: [0, 0, 0.4]}, rest_shape: flat, material: {areal_density: 0.2, thickness: 0.001, "
         "youngs_modulus: 3.0e4, bending_rigidity: 2.0e-4, damping: 0.002, bending_damping: 0.01}" +
         keys + "}\n";
}

std::vector<Case> cases() {
  const std::string corners =
      "grasps:\n  - {name: g, body: a, select: {nearest: [-0.3, 0.3, 0.4]}, stiffness: 20}\n"
      "  - {name: h, body: a, select: {radius: 0.1, center: [0.3, 0.3, 0.4]}}\n";
  const std::string ball =
      "colliders:\n  - sphere: {name: ball, radius: 0.15, pose: {position: [0.02, 0.01, 0.244]}, friction: 0}\n";
  return {{"Springs", cloth("") + corners},
          {"Quadratic", cloth(", bending: quadratic") + corners + "air: {damping: 2}\n"},
          {"Hinges", cloth(", bending: hinges") + corners},
          {"Membrane", cloth(", model: membrane, bending: quadratic") + corners},
          {"Draped", cloth(", bending: quadratic") + ball},
          {"DrapedAtFaces", cloth(", contact_points: faces") + ball},
          {"Limited", cloth(", strain_limit: 0.02") + corners},
          {"BesideARope", cloth("") + "  - rope: {name: r, segments: 9, pins: [end_0]}\n" + corners},
          {"Solid",
           "bodies:\n  - soft: {name: b, box: {size: [0.1, 0.1, 0.3], cells: [2, 2, 5]}, pins: [face_z1], material: "
           "{density: "
           "1000, youngs_modulus: 2.0e4, poissons_ratio: 0.4}}\n"}};
}

std::unique_ptr<World> build(const Case& c, const std::string& step) {
  return build_world(load_scene_text(c.text + "step: {" + step + "}\n", "s.yaml"));
}

class Aggregation : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Schemes, Aggregation, testing::Values("implicit_euler", "bdf2", "tr_bdf2"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(Aggregation, ConvergesToTheSolutionOfTheSparseFactorisation) {
  // M a = f(x, v) + contacts has one solution near the start: 1e-7 m after 15 steps, each solved to 1e-7 m/s^2.
  for (const Case& c : cases()) {
    const std::string common =
        "dt: 0.01, newton_iterations: 200, tolerance: 1.0e-7, integrator: " + std::string(GetParam());
    const auto expected = build(c, common + ", linear_solver: direct");
    const auto found = build(c, common + ", linear_solver: multigrid, linear_tolerance: 1.0e-3");
    int reached = 0;
    for (int k = 0; k < 15; ++k) {
      const StepOutcome a = expected->step(), b = found->step();
      ASSERT_TRUE(a.ok && b.ok) << c.name;
      reached += a.report.converged && b.report.converged ? 1 : 0;
    }
    EXPECT_EQ(reached, 15) << c.name;
    EXPECT_LT((expected->state().x - found->state().x).cwiseAbs().maxCoeff(), 1e-7) << c.name;
  }
}

TEST_P(Aggregation, StaysAtRestHoweverFewIterationsItTakes) {
  // A sheet that rests moves no further, however few iterations a step has: r(x) = 0 at the start of every step.
  const Case c{"rest", cases()[1].text};
  const auto settled = build(c,
                             "dt: 0.05, newton_iterations: 100, tolerance: 1.0e-9, linear_solver: multigrid, "
                             "integrator: implicit_euler");
  for (int k = 0; k < 500; ++k) settled->step();
  const auto world = build(c,
                           "dt: 0.02, newton_iterations: 1, tolerance: 1.0e-9, linear_iterations: 1, "
                           "linear_solver: multigrid, integrator: " +
                               std::string(GetParam()));
  const Nodes x = settled->state().x;
  world->apply(command::SetBodyState{"a", x, Nodes::Zero(3, x.cols())});
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world->step().ok);
  EXPECT_LT((world->state().x - x).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(AggregationStage, RepeatsItselfBitByBitWhateverCameBefore) {
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

TEST(AggregationStage, IsOnTheBillByItsName) {
  const auto solver = [](const std::string& text, const std::string& step) {
    const auto world =
        build_world(load_scene_text(text + "step: {linear_solver: multigrid, " + step + "}\n", "s.yaml"));
    for (const BillItem& item : world->bill()) {
      if (item.part == "linear solver") return item.detail.substr(0, item.detail.find(','));
    }
    return std::string();
  };
  const std::string grid = "bodies:\n  - cloth: {name: a, size: [1, 1], cells: [4, 4]}\n";
  EXPECT_EQ(solver(cases()[0].text, "integrator: bdf2"), "multigrid on aggregates");
  EXPECT_EQ(solver(grid, "integrator: bdf2"), "multigrid on grids");
  EXPECT_EQ(solver(grid, "integrator: implicit_midpoint"), "conjugate gradient");
}

}  // namespace
}  // namespace deformable_sim
