// The headless program: exit codes, JSON, frames.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/mesh_file.h"
#include "deformable_sim/scene/state_file.h"

namespace deformable_sim {
namespace {

struct Outcome {
  int code = -1;
  std::string out;
};

Outcome run(const std::string& arguments) {
  Outcome outcome;
  FILE* pipe = popen((std::string(SIMULATE_PATH) + " " + arguments).c_str(), "r");
  if (!pipe) return outcome;
  std::array<char, 4096> buffer{};
  while (size_t n = fread(buffer.data(), 1, buffer.size(), pipe)) outcome.out.append(buffer.data(), n);
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

TEST(Simulate, RefusesBadArgumentsWithCode2AndUsage) {
  for (const char* arguments :
       {"", "--seconds", "--seconds 0 minimal", "--seconds nan minimal", "--seconds -1 minimal", "--seconds 1x minimal",
        "--every 0 minimal", "--format xyz minimal", "--frobnicate minimal", "--threads 0 minimal",
        "--threads 65 minimal", "--threads two minimal", "minimal flag", "--set =1 minimal", "--set gravity minimal"}) {
    const Outcome outcome = run(std::string(arguments) + " 2>&1");
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.out.find("usage: simulate"), std::string::npos) << arguments << "\n" << outcome.out;
  }
}

TEST(Simulate, JudgesTheStepAfterAGraspSlips) {
  const Outcome outcome =
      run(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data/slip_of_a_rod.yaml --seconds 0.12 --json");
  ASSERT_EQ(outcome.code, 0);
  const YAML::Node summary = YAML::Load(outcome.out);
  EXPECT_EQ(summary["grasps"]["grasp_1"]["state"].as<std::string>(), "slipped");
  EXPECT_LT(summary["bodies"]["rope_0"]["energies"]["kinetic"].as<double>(), 1e3);
}

TEST(Simulate, LetsNothingSinkIntoCollidersStepByStep) {
  // One SIMD level: rounding decides where a motion as wild as this one goes.
  const char* const level = "DEFORMABLE_SIM_SIMD";
  const char* const was = std::getenv(level);
  const std::string before = was != nullptr ? was : "";
  setenv(level, "sse2", 1);
  const Outcome outcome =
      run(std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data/jerked_pinch.yaml --seconds 0.5 --json");
  was != nullptr ? setenv(level, before.c_str(), 1) : unsetenv(level);
  ASSERT_EQ(outcome.code, 0);
  const YAML::Node summary = YAML::Load(outcome.out);
  EXPECT_LT(summary["max_penetration"].as<double>(), 5e-3);
  EXPECT_GT(summary["max_strain"].as<double>(), 5.0);  // it is no quiet scene
}

TEST(Simulate, RefusesBadScenesWithCode2AndTheReason) {
  const std::vector<std::array<std::string, 2>> cases{
      {"no_such_scene", "no scene 'no_such_scene'"},
      {"/dev/null/x.yaml", "no scene"},
      {"minimal --set step.dt=-1", "--set step.dt: -1 is out of range"},
      {"minimal --set bodies[7].cloth.cells=[1,1]", "index 7 of a list of 1"},
      {"minimal --seconds 0.01 --out /proc/nowhere", "/proc/nowhere: cannot be written to"}};
  for (const auto& [arguments, reason] : cases) {
    const Outcome outcome = run(arguments + " 2>&1");
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.out.find(reason), std::string::npos) << outcome.out;
  }
}

TEST(Simulate, EndsWithOneJsonObject) {
  const Outcome outcome =
      run("curtain --seconds 0.1 --quiet --json --set step.dt=0.01 --set bodies[0].cloth.cells=[4,3] 2>/dev/null");
  ASSERT_EQ(outcome.code, 0);
  const YAML::Node json = YAML::Load(outcome.out);  // JSON is YAML
  EXPECT_NEAR(json["time"].as<double>(), 0.1, 1e-9);
  EXPECT_EQ(json["steps"].as<int>(), 10);
  EXPECT_NE(json["solver"].as<std::string>().find("asked for an error of 1 %"), std::string::npos);
  for (const char* key : {"cpu_seconds", "wall_seconds", "real_time_factor", "max_penetration"}) {
    EXPECT_GE(json[key].as<double>(), 0.0) << key;
  }
  const YAML::Node body = json["bodies"]["curtain"];
  EXPECT_EQ(body["nodes"].as<int>(), 20);
  EXPECT_GT(body["max_strain"].as<double>(), 0.0);
  for (const char* kind : {"kinetic", "elastic", "potential"})
    EXPECT_TRUE(body["energies"][kind].as<double>() > 0.0) << kind;
  EXPECT_NEAR(body["bounds"]["max"][0].as<double>(), 0.5, 0.05);
  EXPECT_NEAR(body["center_of_mass"][2].as<double>(), 1.2, 0.1);
  const YAML::Node grasp = json["grasps"]["pin_curtain_corner_2"];
  EXPECT_LT(grasp["force"][2].as<double>(), 0.0) << "the curtain pulls its pins down";
  EXPECT_EQ(grasp["torque"].size(), 3u);
  EXPECT_GT(json["bill"].size(), 0u);
  EXPECT_TRUE(json["bill"][0]["part"].IsScalar());
  EXPECT_EQ(json["warnings"].size(), 0u);
}

TEST(Simulate, ReportsSoftBodiesAndWhatTheirModelCannotDo) {
  const std::string linear =
      "rubber_beam --set step.solver=manual --set bodies[0].soft.element=tetrahedron --seconds 0.02 ";
  const Outcome outcome = run(linear + "--quiet --json 2>/dev/null");
  ASSERT_EQ(outcome.code, 0);
  const YAML::Node json = YAML::Load(outcome.out);
  EXPECT_EQ(json["bodies"]["beam"]["nodes"].as<int>(), 44);
  EXPECT_GT(json["bodies"]["beam"]["energies"]["elastic"].as<double>(), 0.0);
  ASSERT_EQ(json["warnings"].size(), 1u);
  EXPECT_NE(json["warnings"][0].as<std::string>().find("linear tetrahedra bend about"), std::string::npos);
  EXPECT_NE(run(linear + "2>/dev/null").out.find("warning     body beam: linear tetrahedra"), std::string::npos);
}

TEST(Simulate, WritesTheSurfaceOfASoftBody) {
  const std::string dir = testing::TempDir() + "/soft_frames";
  ASSERT_EQ(run("soft_cube_on_table --seconds 0.01 --out " + dir + " --format obj 2>/dev/null").code, 0);
  std::ifstream file(dir + "/cube_000000.obj");
  int vertices = 0, faces = 0;
  for (std::string line; std::getline(file, line);) {
    vertices += line.rfind("v ", 0) == 0;
    faces += line.rfind("f ", 0) == 0;
  }
  EXPECT_EQ(vertices, 125) << "every node, also those inside";
  EXPECT_EQ(faces, 6 * 4 * 8) << "6 sides of 2 x 2 cells, each side of a cell cut in 2, each of those in 4";
}

TEST(Simulate, WritesFramesThatReadBackExactly) {
  // 17 significant digits give the same bits back: the last frame equals the same steps made here.
  const SceneSpec spec =
      load_scene_file(find_scene("rope_between_grippers", default_scene_dir()), {{"step.dt", "0.01"}});
  const std::unique_ptr<World> world = build_world(spec);
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(world->step().ok);
  const Snapshot expected = world->snapshot();
  for (const std::string format : {"csv", "ply", "obj"}) {
    const std::string dir = testing::TempDir() + "frames_" + format;
    std::filesystem::remove_all(dir);
    const Outcome outcome =
        run("rope_between_grippers --set step.dt=0.01 --seconds 0.1 --every 0.05 --quiet --format " + format +
            " --out " + dir);
    ASSERT_EQ(outcome.code, 0);
    EXPECT_FALSE(std::filesystem::exists(dir + "/rope_000003." + format)) << "frames at 0, 0.05 and 0.1 s";
    std::ifstream file(dir + "/rope_000002." + format);
    ASSERT_TRUE(file.good()) << format;
    std::string line;
    int node = 0, velocity = 0;
    while (std::getline(file, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream words(line);
      std::vector<double> numbers;
      std::string first;
      if (format == "obj") words >> first;
      for (double number; words >> number;) numbers.push_back(number);
      if (format == "csv" && numbers.size() == 7) numbers.erase(numbers.begin());
      if (format == "obj" && first == "v" && numbers.size() == 3) {
        EXPECT_EQ((Vec3(numbers[0], numbers[1], numbers[2]) - expected.x.col(node++)).norm(), 0.0);
      } else if (format == "obj" && first == "#v") {
        EXPECT_EQ((Vec3(numbers[0], numbers[1], numbers[2]) - expected.v.col(velocity++)).norm(), 0.0);
      } else if (numbers.size() == 6) {
        EXPECT_EQ((Vec3(numbers[0], numbers[1], numbers[2]) - expected.x.col(node++)).norm(), 0.0);
        EXPECT_EQ((Vec3(numbers[3], numbers[4], numbers[5]) - expected.v.col(velocity++)).norm(), 0.0);
      }
    }
    EXPECT_EQ(node, expected.x.cols()) << format;
    EXPECT_EQ(velocity, expected.v.cols()) << format;
  }
}

TEST(Simulate, WritesClothThatLoadsAsAMeshAgain) {
  for (const std::string format : {"ply", "obj"}) {
    const std::string dir = testing::TempDir() + "cloth_" + format;
    ASSERT_EQ(run("minimal --seconds 0.01 --quiet --format " + format + " --out " + dir).code, 0);
    const TriangleMesh mesh = load_mesh(dir + "/cloth_000000." + format, 1.0);
    EXPECT_EQ(mesh.rest.cols(), 21 * 21);
    EXPECT_EQ(mesh.triangles.size(), 2u * 20 * 20);
  }
}

TEST(Simulate, StopsOnAnInterruptWithItsSummary) {
  // The first frame is written by the loop that watches for the signal; a program that ended does not keep us waiting.
  const std::string dir = testing::TempDir() + "interrupted";
  std::filesystem::remove_all(dir);
  const Outcome outcome =
      run("minimal --seconds 100000 --json --quiet --set bodies[0].cloth.cells=[2,2] --set "
          "bodies[0].cloth.pins=[corner_0] --set colliders=[] --out " +
          dir + " --every 1000 & PID=$!; while [ ! -e " + dir +
          "/cloth_000000.csv ] && kill -0 $PID; do :; done; kill -INT $PID; wait $PID");
  EXPECT_EQ(outcome.code, 130);
  EXPECT_NE(outcome.out.find("\"time\": "), std::string::npos);
}

TEST(Simulate, GoesOnFromASavedStateToTheSameBitsInAnotherProcess) {
  std::string name = (std::filesystem::temp_directory_path() / "simulate_saved_XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(name.data());
  const std::string first = (folder / "first").string(), end = (folder / "end").string();
  const std::string scene = "towel_on_table --quiet --set bodies[0].cloth.cells=[20,16] --seconds ";
  ASSERT_EQ(run(scene + "0.4 --save " + first).code, 0);
  ASSERT_EQ(run(scene + "0.3 --threads 2 --restore " + first + " --save " + end).code, 0);
  const std::unique_ptr<World> world = build_world(
      load_scene_file(find_scene("towel_on_table", default_scene_dir()), {{"bodies[0].cloth.cells", "[20,16]"}}));
  while (world->time() < 0.4 - 1e-9) ASSERT_TRUE(world->step().ok);
  EXPECT_TRUE(world->save() == read_state_file(first).world);
  while (world->time() < 0.7 - 1e-9) ASSERT_TRUE(world->step().ok);
  EXPECT_TRUE(world->save() == read_state_file(end).world);

  Outcome refused = run("minimal --seconds 0.1 --restore " + first + " 2>&1");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.out.find("of another scene"), std::string::npos) << refused.out;
  refused = run(scene + "0.1 --restore " + (folder / "none").string() + " 2>&1");
  EXPECT_EQ(refused.code, 2);
  refused = run(scene + "0.1 --save /proc/nowhere 2>&1");
  EXPECT_EQ(refused.code, 2);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace deformable_sim
