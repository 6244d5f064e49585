// The map of what is stable: limits of explicit schemes, classes of known cells, and the program's refusals.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "study/stability_command.h"
#include "study/stability_map.h"

namespace deformable_sim::stability {
namespace {

namespace fs = std::filesystem;

constexpr double kMost = 5.0;  // CPU s, far more than any of these cells takes

SolverSettings direct() {
  SolverSettings settings;
  settings.linear = SolverSettings::Linear::kDirect;
  settings.newton_iterations = 20;
  return settings;
}

Point stiff(double modulus) {
  Point at;
  at.stiffness = modulus;
  return at;
}

class ExplicitLimit : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Registry, ExplicitLimit, testing::ValuesIn(limited_schemes()),
                         [](const auto& scheme) { return scheme.param; });

TEST_P(ExplicitLimit, OfAChainIsThatOfTheoryAtEveryDampingRatio) {
  // The least of stability_limit(zeta_i) / omega_i over the modes of the chain, zeta_i = ratio omega_i / omega_max.
  for (const double ratio : {0.0, 0.1, 0.5, 1.0, 2.0}) {
    const Limit limit = measure_limit("rope", GetParam(), ratio);
    SCOPED_TRACE(ratio);
    // What a world divides its steps by is never longer, but for the 5 % to which the damping rate is known.
    EXPECT_LE(limit.fast, 1.05 * limit.theory);
    EXPECT_GE(limit.fast, 0.45 * limit.theory);
    if (GetParam() == "explicit_euler" && ratio == 0.0) {
      EXPECT_EQ(limit.theory, 0.0);
      continue;
    }
    EXPECT_NEAR(limit.measured, limit.theory, 0.02 * limit.theory);
  }
}

TEST(FastestMotion, OfTheRopeIsThatOfItsSpringsAndMasses) {
  // n equal springs and masses, held at one end and free at the other:
  // omega_k = 2 sqrt(k / m) sin((2 k - 1) pi / (2 (2 n + 1))), the highest at k = n.
  const Fastest fastest = fastest_of(make_rope(stiff(1e7)));
  const double highest = 2.0 * std::sqrt(1e4 / 0.01) * std::sin(19.0 * M_PI / 42.0);
  EXPECT_NEAR(fastest.omega, highest, 1e-3 * highest);
  EXPECT_NEAR(fastest.rate, 1.0, 0.05);  // drag
}

TEST(Reference, IsWhatAnotherSchemeConvergesTo) {
  // rk4 against TR-BDF2, whose error of second order is (omega dt)^2 / 12 a radian of the swing, omega some 10 1/s.
  const Subject rope = make_rope(stiff(1e9));
  const double dt = 1e-3;
  const Reference reference(rope, {dt}, kMost);
  EXPECT_EQ(reference.method(), "rk4");
  ASSERT_NE(reference.at(instant(dt, kQuarters)), nullptr);
  EXPECT_LT(reference.at(instant(dt, kQuarters))->uncertain, 1e-6);
  EXPECT_EQ(reference.at(0.123), nullptr);
  const Outcome outcome = run_scheme(rope, "tr_bdf2", direct(), dt, reference, kMost);
  EXPECT_EQ(outcome.verdict, Class::kRight);
  EXPECT_LT(outcome.error, 1e-4);
}

TEST(Cell, IsRightBelowAnExplicitLimitAndDivergesAboveIt) {
  const Subject rope = make_rope(stiff(1e7));
  const Fastest fastest = fastest_of(rope);
  for (const std::string name : {"symplectic_euler", "velocity_verlet", "rk4"}) {
    const double limit = stable_step(*make_integrator(name, {}), fastest.omega, fastest.rate);
    const double below = 0.5 * limit, above = 1.3 * limit;
    const Reference reference(rope, {below, above}, kMost);
    EXPECT_EQ(run_scheme(rope, name, {}, below, reference, kMost).verdict, Class::kRight) << name;
    const Outcome outcome = run_scheme(rope, name, {}, above, reference, kMost);
    EXPECT_EQ(outcome.verdict, Class::kDiverged) << name;
    EXPECT_TRUE(std::isinf(outcome.error));
    // As users get it, the same step is cut into parts, which is no doubt about its accuracy.
    SceneSpec spec = rope.spec;
    spec.step.dt = above;
    spec.step.integrator = name;
    const Outcome world = run_world(rope, settings_for(spec, nullptr), 0.0, reference, kMost);
    EXPECT_EQ(world.verdict, Class::kRight) << name;
    EXPECT_FALSE(world.says) << world.note;
  }
}

TEST(Cell, OfFirstOrderIsWrongInLongStepsAndRightInShortOnes) {
  // Implicit Euler falls g t dt / 2 too far in t: 1 % of the rope's metre at t = 0.5 s is a step of some 4 ms.
  const Subject rope = make_rope(stiff(1e7));
  const Reference reference(rope, {1e-3, 0.03}, kMost);
  const Outcome fine = run_scheme(rope, "implicit_euler", direct(), 1e-3, reference, kMost);
  const Outcome coarse = run_scheme(rope, "implicit_euler", direct(), 0.03, reference, kMost);
  EXPECT_EQ(fine.verdict, Class::kRight);
  EXPECT_EQ(coarse.verdict, Class::kWrong);
  EXPECT_GT(coarse.error, 10.0 * fine.error);
}

TEST(Cell, SaysWhyItWasRefused) {
  const Subject sheet = make_sheet(stiff(1e6));
  const Reference sheet_reference(sheet, {0.01}, kMost);
  const Outcome outcome = run_scheme(sheet, "line_dual", {}, 0.01, sheet_reference, kMost);
  EXPECT_EQ(outcome.verdict, Class::kRefused);
  EXPECT_TRUE(outcome.says);
  EXPECT_NE(outcome.note.find("line_dual"), std::string::npos);
}

TEST(Cell, OfAWorldSaysThatItsChoiceExpectsNoPercent) {
  const Subject rope = make_rope(stiff(1e7));
  const Reference reference(rope, {0.01}, kMost);
  WorldSettings settings = settings_for(rope.spec, nullptr);
  settings.dt = 0.01;
  EXPECT_FALSE(run_world(rope, settings, 0.009, reference, kMost).says);
  EXPECT_TRUE(run_world(rope, settings, 0.011, reference, kMost).says);
  EXPECT_TRUE(run_world(rope, settings, std::nan(""), reference, kMost).says);
}

TEST(ImplicitSchemes, AreBoundedInTheCornersOfTheMap) {
  // Steps of 1 us and 2 s, moduli of 1e2 and 1e12 Pa; conjugate gradients in single precision know nothing of the
  // masses from k dt^2 / m = 1e8 on, at 1e10 Pa: a step is then wrong, and says so, but bounded.
  for (const double modulus : {1e2, 1e10, 1e12}) {
    const Subject rope = make_rope(stiff(modulus));
    const Reference reference(rope, {1e-6, 2.0}, 1.0);
    for (const std::string& name : integrator_names()) {
      if (!make_integrator(name, {})->needs().jacobian) continue;
      for (const double dt : {1e-6, 2.0}) {
        for (const auto linear : {SolverSettings::Linear::kDirect, SolverSettings::Linear::kConjugateGradient}) {
          SolverSettings settings = direct();
          settings.linear = linear;
          EXPECT_NE(run_scheme(rope, name, settings, dt, reference, kMost).verdict, Class::kDiverged)
              << name << ", " << modulus << " Pa, " << dt << " s, " << static_cast<int>(linear);
        }
      }
    }
  }
}

TEST(DefaultSolver, IsRightOrSaysSoInTheCornersOfTheMap) {
  Plan corners;
  corners.dts = {1e-3, 0.1};  // at 1e2 Pa no two runs agree after some seconds
  const SolverTable table = read_solver_table(solver_table_file());
  for (const double modulus : {1e2, 1e12}) {
    const Column column{"stiffness", "solid", stiff(modulus)};
    int worlds = 0;
    for (const Row& row : run_column(corners, column, kMost, table)) {
      ++worlds;
      EXPECT_TRUE(row.outcome.verdict == Class::kRight || row.outcome.says)
          << row.stepper.text() << ", " << modulus << " Pa, " << row.dt << " s: " << class_text(row.outcome.verdict);
    }
    EXPECT_EQ(worlds, 3);
  }
}

TEST(ScaledScene, HasAllItsStiffnessesMultiplied) {
  const SceneSpec scene = load_scene_text(
      "bodies:\n"
      "  - soft:\n"
      "      name: cube\n"
      "      box: {size: [0.1, 0.1, 0.1], cells: [1, 1, 1]}\n"
      "      element: tetrahedron\n"
      "      material: {youngs_modulus: 1.0e4, density: 1000}\n"
      "      pins: [face_z1]\n",
      "cube");
  const Subject one = make_scaled(scene, stiff(1.0)), hundred = make_scaled(scene, stiff(100.0));
  EXPECT_EQ(one.held.size(), 4u);
  EXPECT_TRUE(one.has_scheme_alone);
  EXPECT_NEAR(fastest_of(hundred).omega, 10.0 * fastest_of(one).omega, 0.01 * fastest_of(hundred).omega);
}

TEST(MapText, HasALineForEachCellAndNamesWhatIsWrongInSilence) {
  Map map;
  Row row;
  row.column = {"stiffness", "rope", stiff(1e7)};
  row.stepper.way = Stepper::Way::kAuto;
  row.dt = 0.01;
  row.limit = std::numeric_limits<double>::infinity();
  row.outcome.verdict = Class::kWrong;
  row.outcome.error = 0.02;
  row.chosen = "bdf2, \"cg\"";
  map.rows = {row, row};
  map.rows[1].outcome.says = true;
  std::istringstream csv(csv_of(map));
  std::string header, silent, said, end;
  std::getline(csv, header);
  std::getline(csv, silent);
  std::getline(csv, said);
  EXPECT_FALSE(std::getline(csv, end));
  EXPECT_EQ(header.substr(0, 20), "slice,body,way,integ");
  EXPECT_NE(silent.find("auto,,,0.01,1e+07,0,1,1,wrong,0.02,0,inf,"), std::string::npos) << silent;
  EXPECT_NE(silent.find("\"bdf2, 'cg'\""), std::string::npos) << silent;
  EXPECT_NE(said.find("wrong,0.02,1,inf,"), std::string::npos) << said;
  const std::string text = text_of(map);
  EXPECT_NE(text.find("in silence: 1 cells"), std::string::npos) << text;
  EXPECT_NE(text.find("error 2 %"), std::string::npos) << text;
}

struct Answer {
  int code;
  std::string out;
};

Answer study(const std::string& arguments) {
  FILE* pipe = popen((std::string(STUDY_PATH) + " stability " + arguments + " 2>&1").c_str(), "r");
  Answer answer{-1, ""};
  char buffer[512];
  while (std::fgets(buffer, sizeof buffer, pipe) != nullptr) answer.out += buffer;
  const int status = pclose(pipe);
  if (WIFEXITED(status)) answer.code = WEXITSTATUS(status);
  return answer;
}

TEST(StudyStability, RefusesBadOptionsByName) {
  for (const auto& [arguments, reason] :
       std::vector<std::array<std::string, 2>>{{"--frobnicate", "unknown option --frobnicate"},
                                               {"--budget", "--budget: needs a value"},
                                               {"--budget nan", "--budget: 'nan' is no time"},
                                               {"--scene no_such_scene", "no scene 'no_such_scene'"},
                                               {"--scene fold_twice", "has a script"},
                                               {"--out /dev/null/here", "cannot make the folder"}}) {
    const Answer answer = study(arguments);
    EXPECT_EQ(answer.code, 2) << arguments << ": " << answer.out;
    EXPECT_NE(answer.out.find(reason), std::string::npos) << arguments << ": " << answer.out;
  }
}

TEST(StudyStability, StopsAtItsBudgetAndCountsWhatItLeftOut) {
  const fs::path folder = fs::temp_directory_path() / ("stability_map_test_" + std::to_string(getpid()));
  const Answer answer = study("--quick --quiet --scene minimal --budget 0.01 --out '" + folder.string() + "'");
  EXPECT_EQ(answer.code, 0) << answer.out;
  EXPECT_NE(answer.out.find("the budget left out"), std::string::npos) << answer.out;
  EXPECT_TRUE(fs::exists(folder / "stability.csv"));
  EXPECT_TRUE(fs::exists(folder / "stability_limits.csv"));
  EXPECT_TRUE(fs::exists(folder / "stability.txt"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace deformable_sim::stability
