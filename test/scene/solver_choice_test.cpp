// `solver: auto`: what it chooses from a table, and that the shipped table gives what it says.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/solver_choice.h"

namespace deformable_sim {
namespace {

const double kNoBudget = std::numeric_limits<double>::infinity();

SolverConfiguration implicit(double dt) {
  SolverConfiguration c;
  c.integrator = "bdf2";
  c.linear_solver = "multigrid";
  c.newton_iterations = 2;
  c.linear_tolerance = 0.1;
  c.linear_iterations = 50;
  c.dt = dt;
  return c;
}

SolverConfiguration explicit_one() {
  SolverConfiguration c;
  c.integrator = "substepped_verlet";
  c.dt = 1.0 / 60.0;
  return c;
}

SceneFeatures sheet(int nodes, double explicit_steps) {
  return {"sheet on a grid", nodes, explicit_steps, false, false};
}

/// Two sheets, four octaves of nodes apart; 0: coarse implicit, 1: fine implicit, 2: explicit.
SolverTable two_sheets() {
  SolverTable table;
  table.configurations = {implicit(1.0 / 60.0), implicit(1.0 / 240.0), explicit_one()};
  table.scenes.push_back({"small", sheet(100, 10), {{0, 0.02, 0.1}, {1, 0.004, 0.4}, {2, 1e-4, 1.0}}, {}, {}});
  table.scenes.push_back({"large", sheet(1600, 40), {{0, 0.02, 1.6}, {1, 0.004, 6.4}, {2, 1e-4, 64.0}}, {}, {}});
  return table;
}

size_t chosen(const SolverTable& table, const SolverChoice& choice) {
  for (size_t k = 0; k < table.configurations.size(); ++k) {
    if (table.configurations[k].text() == choice.configuration.text() &&
        table.configurations[k].dt == choice.configuration.dt) {
      return k;
    }
  }
  return table.configurations.size();
}

TEST(SolverChoice, IsTheCheapestThatIsAccurateEnough) {
  const SolverTable table = two_sheets();
  const auto at = [&table](double error) {
    return chosen(table, choose_solver(sheet(100, 10), {error, kNoBudget, {}}, table));
  };
  EXPECT_EQ(at(0.02), 0u);
  EXPECT_EQ(at(0.019), 1u);
  EXPECT_EQ(at(0.003), 2u);
}

TEST(SolverChoice, SaysThatItGuessesFarFromAllThatWasMeasured) {
  // Six octaves in nodes, explicit steps or both: 100 nodes at 10 steps is the nearest.
  const SolverTable table = two_sheets();
  const SolverChoice near = choose_solver(sheet(100, 10.0 / 63.0), {0.02, kNoBudget, {}}, table);
  EXPECT_FALSE(near.guessed);
  EXPECT_EQ(near.why.find("a guess"), std::string::npos) << near.why;
  const SolverChoice far = choose_solver(sheet(100, 10.0 / 65.0), {0.02, kNoBudget, {}}, table);
  EXPECT_TRUE(far.guessed);
  EXPECT_NE(far.why.find("unlike anything measured in nodes or stiffness: a guess"), std::string::npos) << far.why;
}

TEST(SolverChoice, InterpolatesCostPerNodeAndPerExplicitStep) {
  // Both sheets cost 1e-3 a node with implicit steps of 1/60 s and 1e-3 a node and explicit step: so does one between.
  const SolverTable table = two_sheets();
  const SolverChoice coarse = choose_solver(sheet(400, 25), {0.03, kNoBudget, {}}, table);
  EXPECT_NEAR(coarse.cpu, 0.4, 1e-9);
  EXPECT_NEAR(coarse.error, 1.5 * 0.02, 1e-12) << "of a scene that was not measured itself";
  const SolverChoice fine = choose_solver(sheet(400, 25), {0.001, kNoBudget, {}}, table);
  EXPECT_NEAR(fine.cpu, 1e-3 * 400 * 25, 1e-9);
}

TEST(SolverChoice, TakesNothingThatFailedInASimilarScene) {
  SolverTable table = two_sheets();
  table.scenes[1].runs.erase(table.scenes[1].runs.begin());
  table.scenes[1].failed = {0};
  EXPECT_EQ(chosen(table, choose_solver(sheet(400, 20), {0.02, kNoBudget, {}}, table)), 1u);
}

TEST(SolverChoice, GivesUpAccuracyForItsBudgetAndSaysSo) {
  const SolverTable table = two_sheets();
  const SolverChoice choice = choose_solver(sheet(1600, 40), {0.001, 8.0, {}}, table);
  EXPECT_EQ(chosen(table, choice), 1u) << "the most accurate that 8 CPU s/s pay for";
  EXPECT_NE(choice.why.find("more than the budget of 8"), std::string::npos) << choice.why;
  const SolverChoice least = choose_solver(sheet(1600, 40), {0.001, 0.1, {}}, table);
  EXPECT_EQ(chosen(table, least), 0u) << "nothing can be paid for: the cheapest";
}

TEST(SolverChoice, SaysWhenNothingReachesTheError) {
  const SolverTable table = two_sheets();
  const SolverChoice choice = choose_solver(sheet(100, 10), {1e-5, kNoBudget, {}}, table);
  EXPECT_EQ(chosen(table, choice), 2u);
  EXPECT_NE(choice.why.find("nothing measured reaches it"), std::string::npos) << choice.why;
}

TEST(SolverChoice, DividesALongStepAndPaysForAShortOne) {
  const SolverTable table = two_sheets();
  // 0.01 s is 2.4 steps of 1/240 s: three parts.
  const SolverChoice divided = choose_solver(sheet(100, 10), {0.01, kNoBudget, 0.01}, table);
  EXPECT_EQ(divided.parts, 3);
  EXPECT_EQ(divided.configuration.dt, 0.01);
  EXPECT_NEAR(divided.cpu, 0.4 * 3 / (0.01 * 240), 1e-9);
  // Sixteen steps where the table has one.
  const SolverChoice often = choose_solver(sheet(100, 10), {0.02, kNoBudget, 1.0 / 960.0}, table);
  EXPECT_EQ(often.parts, 1);
  EXPECT_GT(often.cpu, 0.9) << "explicit, which divides a step anyway, or sixteen times 0.1";
}

TEST(SolverChoice, IsMeasuredInContactForAContactSceneOrRobust) {
  SolverTable table = two_sheets();
  SceneFeatures touching = sheet(400, 20);
  touching.contact = true;
  const SolverChoice robust = choose_solver(touching, {0.02, kNoBudget, {}}, table);
  EXPECT_FALSE(robust.measured());
  EXPECT_EQ(robust.configuration.integrator, "implicit_euler");
  EXPECT_NE(robust.why.find("(sheet on a grid in contact) was measured"), std::string::npos) << robust.why;
  SceneFeatures ball = sheet(3200, 40);
  ball.contact = true;
  table.scenes.push_back({"ball", ball, {{1, 0.01, 20.0}}, {0}, {}});
  const SolverChoice choice = choose_solver(touching, {0.02, kNoBudget, {}}, table);
  EXPECT_EQ(chosen(table, choice), 1u);
  EXPECT_NE(choice.why.find("ball"), std::string::npos) << choice.why;
}

TEST(SolverChoice, IsARobustOneWhereNothingAlikeWasMeasured) {
  SceneFeatures other = sheet(100, 10);
  other.bodies = "mixed";
  const SolverChoice choice = choose_solver(other, {}, two_sheets());
  EXPECT_FALSE(choice.measured());
  EXPECT_EQ(choice.configuration.integrator, "implicit_euler");
  EXPECT_NE(choice.why.find("nothing like it (mixed)"), std::string::npos);
}

const SolverTable& shipped() {
  static const SolverTable table = read_solver_table(solver_table_file());
  return table;
}

TEST(SolverTableShipped, NeverChoosesWhatCostsHalfAsMuchAgainAsTheCheapest) {
  constexpr double kMost = 1.5;
  int checked = 0;
  for (const SolverTable::Scene& scene : shipped().scenes) {
    for (const SolverTable::Cheapest& cheapest : scene.cheapest) {
      const SolverChoice choice = choose_solver(scene.features, {cheapest.error, kNoBudget, {}}, shipped());
      const size_t index = chosen(shipped(), choice);
      const auto run = std::find_if(scene.runs.begin(), scene.runs.end(),
                                    [index](const SolverTable::Run& r) { return r.configuration == index; });
      ASSERT_NE(run, scene.runs.end()) << scene.name << ": " << choice.why;
      EXPECT_LE(run->error, cheapest.error) << scene.name << ": " << choice.why;
      EXPECT_LE(run->cpu, kMost * cheapest.cpu) << scene.name << " at " << cheapest.error << ": " << choice.why;
      ++checked;
    }
  }
  EXPECT_GT(checked, 60);
}

TEST(SolverTableShipped, KnowsSheetsRopesRodsAndSolids) {
  for (const char* bodies : {"sheet on a grid", "sheet", "rope", "rod", "solid"}) {
    int count = 0;
    for (const SolverTable::Scene& scene : shipped().scenes) count += scene.features.bodies == bodies;
    EXPECT_GE(count, 2) << bodies;
  }
  const auto& all = shipped().scenes;
  EXPECT_TRUE(std::any_of(all.begin(), all.end(), [](const auto& scene) { return scene.features.bodies == "mixed"; }));
}

/// RMS distance of the points over the largest extent at the start, largest of T/4, T/2, 3T/4 and T.
double error_of(const SceneSpec& spec, World* other, double seconds) {
  const std::unique_ptr<World> world = build_world(spec);
  const Nodes start = world->state().x;
  const double size = (start.rowwise().maxCoeff() - start.rowwise().minCoeff()).maxCoeff();
  double error = 0.0;
  for (int quarter = 1; quarter <= 4; ++quarter) {
    const double until = 0.25 * quarter * seconds - 1e-9;
    while (world->time() < until) EXPECT_TRUE(world->step().ok);
    while (other->time() < until) EXPECT_TRUE(other->step().ok);
    const Nodes off = world->state().x - other->state().x;
    error = std::max(error, std::sqrt(off.squaredNorm() / static_cast<double>(off.cols())) / size);
  }
  return error;
}

TEST(SolverAuto, DeliversThePercentItIsAskedForOnASheetThatWasNotMeasured) {
  // Against Verlet at a third of its limit, whose error is a hundredth of that.
  const char* scene =
      "air: {damping: 3}\n"
      "bodies:\n"
      "  - cloth:\n"
      "      {name: sheet, size: [0.8, 0.8], cells: [28, 28], model: springs, bending: quadratic,\n"
      "       material: {areal_density: 0.25, membrane_stiffness: 1.5e3, bending_rigidity: 1.0e-5, damping: 0,\n"
      "                  bending_damping: 0.01}, pins: [corner_2, corner_3]}\n";
  for (const double accuracy : {0.03, 0.01, 0.003}) {
    const std::unique_ptr<World> exact = build_world(load_scene_text(
        scene, "exact",
        {{"step.integrator", "substepped_verlet"}, {"step.fraction_of_limit", "0.3"}, {"step.dt", "0.0125"}}));
    const SceneSpec chosen_by_error = load_scene_text(
        scene, "auto", {{"step.accuracy", std::to_string(accuracy)}, {"step.dt", "0.0125"}, {"step.budget", "1e6"}});
    EXPECT_LE(error_of(chosen_by_error, exact.get(), 1.0), accuracy) << build_world(chosen_by_error)->settings().chosen;
  }
}

TEST(SolverAuto, IsWhatAScenesGetsThatNamesNoPartOfASolver) {
  const auto mode = [](const std::string& step) {
    return load_scene_text(step + "bodies:\n  - rope: {name: r}\n", "scene").step.mode;
  };
  EXPECT_EQ(mode(""), SolverMode::kAuto);
  EXPECT_EQ(mode("step: {dt: 0.005, accuracy: reference, budget: 2}\n"), SolverMode::kAuto);
  EXPECT_EQ(mode("step: {solver: auto}\n"), SolverMode::kAuto);
  EXPECT_EQ(mode("step: {solver: manual}\n"), SolverMode::kManual);
  EXPECT_EQ(mode("step: {newton_iterations: 3}\n"), SolverMode::kManual);
  EXPECT_EQ(mode("step: {integrator: bdf2}\n"), SolverMode::kManual);
}

TEST(SolverChoice, LeavesOutWhatTheModelRefuses) {
  const SolverTable table = two_sheets();
  const SolverChoice choice = choose_solver(sheet(100, 10), {0.001, kNoBudget, {}}, table,
                                            [](const std::string& name) { return name != "substepped_verlet"; });
  EXPECT_EQ(chosen(table, choice), 1u);
}

TEST(SolverAuto, RunsScenesThatTheCheapestSolversRefuse) {
  // Consistent masses, which explicit schemes cannot take; hinges on a grid, which no kernel of rows knows.
  const std::vector<std::string> bodies{
      "  - soft: {name: a, box: {size: [0.1, 0.1, 0.1], cells: [2, 2, 2]}, mass: consistent, element: tetrahedron,\n"
      "           material: {youngs_modulus: 1.0e4}, pins: [face_x0]}\n",
      "  - cloth: {name: a, cells: [8, 8], pins: [corner_2, corner_3], material: cotton_voile}\n"};
  for (const std::string& body : bodies) {
    for (const char* accuracy : {"interactive", "engineering", "reference"}) {
      const SceneSpec spec =
          load_scene_text("step: {accuracy: " + std::string(accuracy) + "}\nbodies:\n" + body, "scene");
      const std::unique_ptr<World> world = build_world(spec);
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(world->step().ok) << world->settings().chosen;
    }
  }
}

TEST(SceneFeatures, CallASheetOneOnAGridOnlyWhereTheKernelsOfRowsKnowAllOfIt) {
  const auto bodies = [](const std::string& keys, const std::string& more) {
    const SceneSpec spec = load_scene_text(
        more + "bodies:\n  - cloth: {name: a, cells: [4, 4], material: {bending_rigidity: 1.0e-5}" + keys + "}\n",
        "scene");
    return features_of(spec, *build_model(spec)).bodies;
  };
  EXPECT_EQ(bodies(", bending: quadratic", ""), kSheetOnGrid);
  EXPECT_EQ(bodies(", bending: hinges", ""), "sheet");
  EXPECT_EQ(bodies(", bending: quadratic", "air: {drag_coefficient: 1}\n"), "sheet");
  EXPECT_EQ(bodies(", model: membrane", ""), "sheet");
}

TEST(SolverAuto, RefusesToMixWithAPartOfASolverNamingTheLine) {
  const auto refusal = [](const std::string& step) -> std::string {
    try {
      load_scene_text("bodies:\n  - rope: {name: r}\nstep:\n" + step, "scene");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal("  solver: auto\n  integrator: bdf2\n"),
            "scene:5: step.integrator: solver: auto chooses it; leave out one of the two");
  EXPECT_EQ(refusal("  accuracy: reference\n  integrator: bdf2\n"),
            "scene:4: step.accuracy: belongs to solver: auto or a control; step.integrator rules it out");
  EXPECT_EQ(refusal("  solver: manual\n  budget: 1\n"),
            "scene:5: step.budget: belongs to solver: auto or a control; manual rules it out");
  EXPECT_EQ(refusal("  accuracy: good\n"),
            "scene:4: step.accuracy: must be interactive, engineering, reference or a number, 1e-05 ... 0.1");
  EXPECT_EQ(refusal("  accuracy: 0.5\n"), "scene:4: step.accuracy: 0.5 is out of range; allowed: 1e-05 ... 0.1");
}

TEST(SolverTableFile, IsRefusedWithItsLine) {
  const auto refusal = [](const std::string& text) -> std::string {
    const std::string path = testing::TempDir() + "solvers.yaml";
    std::ofstream(path) << text;
    try {
      read_solver_table(path);
    } catch (const InputError& error) {
      return std::string(error.what()).substr(path.size());
    }
    return "";
  };
  const std::string configurations = "configurations:\n  - {integrator: bdf2, dt: 0.01}\n";
  const std::string scene = "scenes:\n  - {name: a, bodies: rope, nodes: 2, explicit_steps: 1, ";
  EXPECT_EQ(refusal(configurations + scene + "runs: [[0, 0.1, 1]]}\n"), "");
  EXPECT_EQ(refusal(configurations + scene + "runs: [[1, 0.1, 1]]}\n"),
            ":4: scenes.runs: 1 is out of range; allowed: 0 ... 0");
  EXPECT_EQ(refusal(configurations + scene + "runs: [[0, -0.1, 1]]}\n").substr(0, 3), ":4:");
  EXPECT_EQ(refusal("scenes: []\n").substr(0, 3), ":1:");
  EXPECT_THROW(read_solver_table("/nowhere/solvers.yaml"), InputError);
}

}  // namespace
}  // namespace deformable_sim
