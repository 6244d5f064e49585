// Scenes made at random: the generator, what is watched, the reducer, some seeds, and every scene that once failed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "study/fuzz_crossing.h"
#include "study/fuzz_reduce.h"
#include "study/fuzz_run.h"
#include "study/fuzz_scene.h"
#include "study/fuzz_watch.h"

namespace deformable_sim::fuzz {
namespace {

namespace fs = std::filesystem;

const std::string kScenes = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/regression/scenes";

/// A folder with the meshes that scenes name.
std::string mesh_folder() {
  const fs::path dir = fs::temp_directory_path() / "deformable_sim_fuzz_test";
  write_meshes(dir.string());
  return dir.string();
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(FuzzGenerator, GivesTheSameTextForTheSameSeedAndAnotherForTheNext) {
  std::set<std::string> texts;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::string text = text_of(make_case(seed));
    EXPECT_EQ(text, text_of(make_case(seed))) << seed;
    texts.insert(text.substr(text.find('\n')));  // the title names the seed
  }
  EXPECT_EQ(texts.size(), 200u);
}

TEST(FuzzGenerator, MakesEveryKindOfSceneWithinAThousandSeeds) {
  std::vector<std::string> wanted{"cloth: {",
                                  "rope: {",
                                  "soft: {",
                                  "model: provot",
                                  "model: membrane",
                                  "model: untwisted",
                                  "model: rod",
                                  "closed: true",
                                  "creases: [",
                                  "bending: hinges",
                                  "path: [",
                                  "initial_twist",
                                  "lattice: {",
                                  "neighbours: 26",
                                  "mass: consistent",
                                  "strain_limit",
                                  "touches: all",
                                  "touches: others",
                                  "sphere: {",
                                  "cylinder: {",
                                  "capsule: {",
                                  "plane: {",
                                  "cone: {",
                                  "mesh: {",
                                  "box: {name",
                                  "0.0005]",
                                  "lets_through",
                                  "nearest: [",
                                  "radius: ",
                                  "feature: ",
                                  "nodes: [",
                                  "max_force",
                                  "move_grasp",
                                  "move_collider",
                                  "release",
                                  "wind: [",
                                  "drag_",
                                  "gravity: [0, 0, 0",
                                  "accuracy: ",
                                  "budget: ",
                                  "precision: ",
                                  "jacobian: ",
                                  "cg",
                                  "direct",
                                  "banded",
                                  "multigrid",
                                  "#! ",
                                  " add_collider ",
                                  " set_state ",
                                  " scatter ",
                                  " remove_collider ",
                                  " let_through ",
                                  " reset",
                                  "contact_points: faces",
                                  "law: hooke",
                                  "law: neo_hookean",
                                  "law: mooney_rivlin",
                                  "steel",
                                  "natural_twist",
                                  "contact_points: anywhere",
                                  "rest_shape: ",
                                  "tetrahedron",
                                  "slivers.mesh",
                                  "element: springs",
                                  "section: ",
                                  "sheet_slivers.obj"};
  for (const std::string& name : integrator_names()) wanted.push_back("integrator: " + name);
  std::string all;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) all += text_of(make_case(seed));
  for (const std::string& part : wanted) EXPECT_TRUE(contains(all, part)) << part;
}

TEST(FuzzGenerator, MakesScenesThatTheLoaderTakes) {
  // A generator of refused scenes tests the loader alone: at most one in eight.
  const std::string dir = mesh_folder();
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 160; ++seed) {
    try {
      const SceneSpec scene = load_scene_text(text_of(make_case(seed)), dir + "/case.yaml");
      build_model(scene);
    } catch (const InputError& error) {
      ++refused;
      EXPECT_TRUE(contains(error.what(), "case.yaml:")) << seed << ": " << error.what();
    }
  }
  EXPECT_LE(refused, 20);
}

TEST(FuzzReducer, LeavesWhatTheFailureNeeds) {
  // A fault that shows with a cone of a radius above 1 mm and any rope, after a command that scatters.
  const auto fails = [](const Case& c) {
    const std::string text = text_of(c);
    const size_t at = text.find("cone: {");
    if (at == std::string::npos || !contains(text, "rope: {") || !contains(text, "#! 0.3 scatter")) return false;
    const size_t radius = text.find("radius: ", at);
    return radius != std::string::npos && std::stod(text.substr(radius + 8)) > 0.001;
  };
  Case found;
  for (std::uint64_t seed = 0; found.scene.empty(); ++seed) {
    Case c = make_case(seed);
    c.commands.emplace_back("#! 0.3 scatter rope_0 0.1 7");
    if (fails(c)) found = c;
  }
  const Case small = reduce(found, fails, 1000);
  EXPECT_TRUE(fails(small));
  ASSERT_EQ(small.commands.size(), 1u);
  ASSERT_EQ(small.scene.items.size(), 2u) << text_of(small);
  EXPECT_EQ(small.scene.find("bodies")->items.size(), 1u);
  EXPECT_EQ(small.scene.find("colliders")->items.size(), 1u);
  EXPECT_LT(text_of(small).size(), 130u) << text_of(small);
}

TEST(FuzzReducer, GivesUpAfterSoManyTrials) {
  int trials = 0;
  reduce(
      make_case(3), [&trials](const Case&) { return ++trials < 0; }, 7);
  EXPECT_EQ(trials, 7);
}

TEST(FuzzIsolation, TellsOfACrash) {
  Limits limits;
  limits.begins = [](const std::string&, bool) { std::abort(); };
  const Outcome o = run_isolated("bodies: [{rope: {name: a}}]\n", "a.yaml", limits, Depth::kOnce);
  EXPECT_EQ(o.what, "crash");
  EXPECT_EQ(o.end, Outcome::End::kFound);
}

TEST(FuzzIsolation, BringsTheOutcomeBack) {
  const std::string scene = "step: {integrator: bdf2, dt: 0.01}\nbodies: [{rope: {name: a, segments: 3}}]\n";
  const Outcome there = run_isolated(scene, "a.yaml", Limits(), Depth::kCompared),
                here = run_case(scene, "a.yaml", Limits());
  EXPECT_EQ(there.end, Outcome::End::kDone);
  EXPECT_EQ(there.integrator, "bdf2");
  EXPECT_EQ(there.steps, 100);
  EXPECT_EQ(there.bits, here.bits);
  EXPECT_EQ(run_isolated("bodies: 3\n", "a.yaml", Limits(), Depth::kOnce).end, Outcome::End::kRefused);
}

/// What is said of a scene, in which nothing is wrong, after `change`.
std::string watched(const std::string& scene, const std::function<void(World*)>& change) {
  const SceneSpec spec = load_scene_text(scene, "a.yaml");
  const std::unique_ptr<World> world = build_world(spec);
  Watch watch(spec, *world, Watch::Grasps::kRigid);
  for (int k = 0; k < 10; ++k) {
    world->step();
    const Finding finding = watch.look(*world);
    EXPECT_EQ(finding.what, "") << finding.detail;
  }
  change(world.get());
  for (int k = 0; k < 10; ++k) {
    world->step();
    const Finding finding = watch.look(*world);
    if (!finding.what.empty()) return finding.what;
  }
  return "";
}

const char kRope[] =
    "step: {integrator: implicit_euler, dt: 0.01}\nbodies: [{rope: {name: a, segments: 5, pins: [end_0]}}]\n";

TEST(FuzzWatch, SeesEnergyThatCameFromNowhere) {
  const auto kick = [](double speed) {
    return [speed](World* world) {
      const Nodes& x = world->state().x;
      world->apply(command::SetBodyState{"a", x, Nodes::Constant(3, x.cols(), speed)});
    };
  };
  EXPECT_EQ(watched(kRope, kick(20.0)), "energy");
  EXPECT_EQ(watched(kRope, kick(0.0)), "");
}

TEST(FuzzWatch, SeesNodesThatAreFar) {
  const auto put = [](World* world) {
    const Nodes& x = world->state().x;
    world->apply(command::SetBodyState{"a", Nodes(x.array() + 2e4), Nodes::Zero(3, x.cols())});
  };
  EXPECT_EQ(watched(kRope, put), "far");
}

TEST(FuzzWatch, SeesNodesInsideAColliderThatNobodyReports) {
  // Put there between two steps, which nothing has measured yet: 5 cm beside the axis of something 10 cm wide there,
  // whose side is upright, but of the cone as steep as it is wide.
  const std::vector<std::pair<std::string, double>> depths{{"sphere: {radius: 0.1, ", 50.0},
                                                           {"capsule: {radius: 0.1, length: 0.2, ", 50.0},
                                                           {"cylinder: {radius: 0.1, length: 0.2, ", 50.0},
                                                           {"cone: {radius: 0.2, length: 0.2, ", 50.0 / std::sqrt(2.0)},
                                                           {"box: {size: [0.2, 0.2, 0.2], ", 50.0}};  // mm
  for (const auto& [shape, depth] : depths) {
    const SceneSpec spec = load_scene_text(
        std::string(kRope) + "colliders: [{" + shape + "name: solid, pose: {position: [9, 0, 0]}}}]\n", "a.yaml");
    const std::unique_ptr<World> world = build_world(spec);
    world->step();
    EXPECT_EQ(Watch(spec, *world, Watch::Grasps::kRigid).look(*world).what, "") << shape;
    const auto put = [&](double place) {
      Nodes x = world->state().x;
      x.col(5) = Vec3(place, 0, 0);
      world->apply(command::SetBodyState{"a", x, Nodes::Zero(3, x.cols())});
      return Watch(spec, *world, Watch::Grasps::kRigid).look(*world);
    };
    const Finding inside = put(9.05);
    EXPECT_EQ(inside.what, "hidden") << shape;
    EXPECT_NEAR(std::atof(inside.detail.c_str()), depth, 0.1) << shape;  // told in three digits
    EXPECT_EQ(put(9.101).what, "") << shape;
  }
}

TEST(FuzzWatch, SeesBodiesThatWentThroughOneAnother) {
  // A sheet on edge through one that lies: 5 cm above it, and down by 5 cm.
  const std::string edge = "size: [0.1, 0.1], cells: [3, 3], touches: others, pose: {position: [0.003, 0.002, 0.1], ";
  const SceneSpec scene = load_scene_text(
      "bodies:\n  - cloth: {name: flat, size: [0.3, 0.3], cells: [4, 4], touches: others}\n  - cloth: {name: knife, " +
          edge + "rpy: [1.5, 0, 0]}}\n  - cloth: {name: ghost, size: [0.3, 0.3], cells: [4, 4], pose: {position: " +
          "[0, 0, 0.1]}}\n",
      "a.yaml");
  const std::shared_ptr<const Model> model = build_model(scene);
  const Body& knife = model->bodies[1];
  std::vector<char> held(static_cast<size_t>(model->node_count()), 0);
  Nodes x = model->initial.x;
  EXPECT_EQ(find_crossing(*model, x, held), "");  // the ghost feels nothing
  x.middleCols(knife.first_node, knife.node_count).row(2).array() -= 0.1;
  EXPECT_NE(find_crossing(*model, x, held), "");
  held.assign(held.size(), 1);
  EXPECT_EQ(find_crossing(*model, x, held), "");
}

TEST(FuzzWatch, TakesNoRoundingOfAFlatSheetForACrossing) {
  // After a step, 1e-20 m from their plane, edges lie on both sides of triangles that they are beside.
  Limits limits;
  limits.steps = 1;
  const Outcome o = run_case(
      "bodies: [{cloth: {name: a, size: [1, 0.002], pose: {rpy: [0, 0, 1]}, touches: all}}]\n"
      "step: {newton_iterations: 1}\n",
      "a.yaml", limits);
  EXPECT_EQ(o.what, "") << o.detail;
  EXPECT_EQ(o.steps, 1);
}

TEST(FuzzedScenes, StandTheirSecond) {
  // Solvers that the program chose may stop in some of them (doc/reliability.md); all else would be a failure.
  const std::string dir = mesh_folder();
  Limits limits;
  limits.cpu = 0.15;
  int stops = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Outcome o = run_case(text_of(make_case(seed)), dir + "/case.yaml", limits);
    if (o.what == "stop") {
      ++stops;
    } else {
      EXPECT_NE(o.end, Outcome::End::kFound) << seed << ": " << o.what << ": " << o.detail;
    }
  }
  EXPECT_LE(stops, 8);
}

TEST(FuzzedScenes, ThatFailedOnceDoNotFailAgain) {
  Limits limits;
  limits.cpu = 20.0;
  int count = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(kScenes)) {
    if (file.path().extension() != ".yaml") continue;
    ++count;
    std::ifstream stream(file.path());
    std::ostringstream text;
    text << stream.rdbuf();
    Outcome o = run_isolated(text.str(), file.path().string(), limits, Depth::kCompared);
    EXPECT_TRUE(o.end == Outcome::End::kDone || o.end == Outcome::End::kStopped)
        << file.path() << ": " << o.what << ": " << o.detail;
  }
  EXPECT_GT(count, 3);
}

}  // namespace
}  // namespace deformable_sim::fuzz
