// A saved state goes on to the same bits; what is no such state is refused and changes nothing.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/script.h"
#include "deformable_sim/scene/state_file.h"

namespace deformable_sim {
namespace {

/// A world and the script it plays.
struct Play {
  explicit Play(const SceneSpec& spec) : world(build_world(spec)), script(spec.script) {}

  void go(int steps) {
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(play(&script, world.get()).status.ok());
      ASSERT_TRUE(world->step().ok);
    }
  }
  std::unique_ptr<World> world;
  Script script;
};

/// Every bit that a step leaves behind, which is what save() writes.
void expect_same(World* a, World* b, const std::string& what) {
  EXPECT_EQ(a->time(), b->time()) << what;
  EXPECT_EQ((a->state().x - b->state().x).cwiseAbs().maxCoeff(), 0.0) << what;
  EXPECT_EQ((a->state().v - b->state().v).cwiseAbs().maxCoeff(), 0.0) << what;
  EXPECT_TRUE(a->save() == b->save()) << what << ": what is remembered differs";
}

/// x(s, 0 -> a + b) = x(restored(s, 0 -> a), -> b), bit by bit; restored into a world that was somewhere else.
void expect_to_go_on(const SceneSpec& spec, int before, int after, const std::string& what) {
  Play one(spec), other(spec);
  one.go(before);
  const std::string saved = one.world->save();
  const Script position = one.script;
  other.go(3);
  other.world->restore(saved);
  other.script = position;
  expect_same(one.world.get(), other.world.get(), what + ", just restored");
  one.go(after);
  other.go(after);
  expect_same(one.world.get(), other.world.get(), what);
}

SceneSpec shipped(const std::string& name) {
  return load_scene_file(find_scene(name, default_scene_dir()));
}

TEST(SavedStates, OfEveryShippedSceneGoOnToTheSameBits) {
  for (const std::string& name : scene_names(default_scene_dir())) expect_to_go_on(shipped(name), 8, 5, name);
}

const char* const kSheet =
    "bodies:\n  - cloth: {name: sheet, size: [0.4, 0.4], cells: [10, 10], pose: {position: [0, 0, 0.26]}, "
    "strain_limit: 0.05}\n  - rope: {name: rope, length: 0.5, segments: 20, pose: {position: [-0.2, 0.1, 0.4]}, "
    "pins: [end_0]}\ncolliders:\n  - sphere: {name: ball, radius: 0.25}\n";

TEST(SavedStates, GoOnToTheSameBitsWithEveryScheme) {
  for (const std::string& name : integrator_names()) {
    const bool implicit = make_integrator(name, {})->needs().jacobian;
    for (const char* linear : {"cg", "direct", "banded", "multigrid"}) {
      if (!implicit && std::string(linear) != "cg") continue;
      const SceneSpec spec = load_scene_text(
          "step: {integrator: " + name + ", dt: 0.004, linear_solver: " + linear + "}\nair: {damping: 1}\n" + kSheet,
          "test");
      expect_to_go_on(spec, 20, 8, name + " " + linear);
    }
  }
}

TEST(SavedStates, HaveBodiesThatTouchAndStick) {
  for (const char* name : {"fold_twice", "pinch_and_lift", "laundry_pile", "overhand_knot"}) {
    expect_to_go_on(shipped(name), 50, 10, name);
  }
}

Collider box_at(const std::string& name, const Vec3& place) {
  Collider box;
  box.name = name;
  Shape shape;
  shape.size = Vec3(0.1, 0.2, 0.1);
  box.shapes.push_back(shape);
  box.world_from_collider.translation() = place;
  return box;
}

TEST(SavedStates, HaveGraspsAndCollidersOfTheRunAndTheirMotions) {
  const SceneSpec spec = load_scene_text(std::string("step: {dt: 0.005, integrator: bdf2}\n") + kSheet, "test");
  Play one(spec), other(spec);
  one.go(5);
  command::Grasp hard, soft;
  hard.request.name = "hard";
  hard.request.body = soft.request.body = "sheet";
  hard.request.selection.method = soft.request.selection.method = SelectionMethod::kFeature;
  hard.request.selection.feature = "corner_0";
  hard.request.max_force = 5.0;
  soft.request.name = "soft";
  soft.request.selection.feature = "corner_3";
  soft.request.stiffness = 100.0;
  Pose up = Pose::Identity();
  up.translation() = Vec3(-0.2, -0.2, 0.6);
  Pose aside = Pose::Identity();
  aside.translation() = Vec3(0.3, 0.3, 0.2);
  for (const Command& c : std::vector<Command>{
           hard, soft, command::MoveGrasp{"hard", up, 0.5}, command::AddCollider{box_at("late", Vec3(0.5, 0.5, 0.2))},
           command::MoveCollider{"late", aside, 0.3}, command::RemoveCollider{"ball"}}) {
    ASSERT_TRUE(one.world->apply(c).status.ok());
  }
  one.go(10);
  other.world->restore(one.world->save());
  expect_same(one.world.get(), other.world.get(), "just restored");
  one.go(30);
  other.go(30);
  expect_same(one.world.get(), other.world.get(), "later");
  const std::vector<GraspReport> grasps = other.world->grasp_reports();
  ASSERT_EQ(grasps.size(), 3u);
  EXPECT_GT(grasps[1].force.norm(), 0.0);
  EXPECT_EQ(grasps[1].force, one.world->grasp_reports()[1].force);
}

TEST(SavedStates, OfAnotherSceneAreRefusedByWhatDiffers) {
  const std::string step = "step: {dt: 0.005, integrator: bdf2}\n";
  Play one(load_scene_text(step + kSheet, "test"));
  one.go(3);
  const std::string saved = one.world->save();
  const auto refusal = [&saved](const std::string& yaml) {
    Play other(load_scene_text(yaml, "test"));
    other.go(2);
    const std::string before = other.world->save();
    try {
      other.world->restore(saved);
    } catch (const InputError& error) {
      EXPECT_TRUE(other.world->save() == before) << "a refusal changed the world";
      return std::string(error.what());
    }
    return std::string();
  };
  std::string fewer = kSheet;
  fewer.replace(fewer.find("[10, 10]"), 8, "[10, 11]");
  EXPECT_NE(refusal(step + fewer).find("of 121 nodes"), std::string::npos);
  EXPECT_NE(refusal("step: {dt: 0.005, integrator: tr_bdf2}\n" + std::string(kSheet)).find("bdf2"), std::string::npos);
  EXPECT_NE(refusal("step: {dt: 0.004, integrator: bdf2}\n" + std::string(kSheet)).find("0.004"), std::string::npos);
  EXPECT_NE(refusal("gravity: [0, 0, -9.8]\n" + step + kSheet).find("gravity"), std::string::npos);
  EXPECT_EQ(refusal(step + kSheet), "");
}

TEST(SavedStates, CutOrAlteredAnywhereNeverHarmTheWorld) {
  // Bytes may mean another state: then it is one that can be stepped. Else they are refused.
  const std::string step = "step: {dt: 0.005, integrator: bdf2}\n";
  const SceneSpec spec = load_scene_text(step + kSheet, "test");
  Play one(spec), other(spec);
  one.go(10);
  command::Grasp grasp;
  grasp.request.name = "g";
  grasp.request.body = "sheet";
  grasp.request.selection.method = SelectionMethod::kFeature;
  grasp.request.selection.feature = "corner_0";
  ASSERT_TRUE(one.world->apply(grasp).status.ok());
  one.go(1);
  const std::string saved = one.world->save();
  std::mt19937 random(3);
  int refused = 0, taken = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::string bytes = saved;
    if (trial % 2 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      bytes[random() % (trial % 4 == 1 ? std::min<size_t>(bytes.size(), 4000) : bytes.size())] ^=
          static_cast<char>(1u << random() % 8u);
    }
    try {
      other.world->restore(bytes);
      ++taken;
    } catch (const InputError&) {
      ++refused;
    }
    other.world->step();
    EXPECT_TRUE(other.world->state().finite());
  }
  EXPECT_GE(refused, 200);
  EXPECT_GT(taken, 0);
  other.world->restore(saved);
  expect_same(one.world.get(), other.world.get(), "after all that");
}

/// A folder of its own, removed at the end.
class StateFiles : public testing::Test {
 protected:
  StateFiles() {
    std::string name = (std::filesystem::temp_directory_path() / "saved_state_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~StateFiles() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  static std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::string refusal_of(const std::string& path) {
    try {
      read_state_file(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::filesystem::path folder_;
};

TEST_F(StateFiles, GiveBackWhatWasWritten) {
  const std::string path = file("new/folder/a.state");
  write_state_file(path, {"towel.yaml", 1.25, 3, std::string("a\0b", 3), "frames"});
  const SavedState read = read_state_file(path);
  EXPECT_EQ(read.scene, "towel.yaml");
  EXPECT_EQ(read.time, 1.25);
  EXPECT_EQ(read.script, 3u);
  EXPECT_EQ(read.world, std::string("a\0b", 3));
  EXPECT_EQ(read.frames, "frames");
}

TEST_F(StateFiles, CutOrWithOneBitTurnedAreRefused) {
  const std::string path = file("a.state");
  write_state_file(path, {"towel.yaml", 1.25, 3, std::string(500, 'w'), ""});
  const std::string whole = bytes_of(path);
  for (size_t k = 0; k < whole.size(); ++k) {
    std::string turned = whole;
    turned[k] ^= static_cast<char>(1u << k % 8u);
    for (const std::string& bytes : {whole.substr(0, k), turned}) {
      std::ofstream(path, std::ios::binary) << bytes;
      EXPECT_NE(refusal_of(path).find(path), std::string::npos) << k;
    }
  }
  std::ofstream(path, std::ios::binary) << whole << "more";
  EXPECT_NE(refusal_of(path), "");
  EXPECT_NE(refusal_of(file("none")), "");
  EXPECT_NE(refusal_of(folder_.string()), "");
  std::ofstream(path, std::ios::binary) << whole;
  EXPECT_EQ(refusal_of(path), "");
}

TEST_F(StateFiles, LoseNothingThatWasSavedWhenTheWriterIsKilled) {
  // A process writes ever larger states of its number until it is killed at a random moment: what is there is whole,
  // and no older than the last one it told us was written.
  std::mt19937 random(5);
  const std::string path = file("a.state");
  for (int trial = 0; trial < 30; ++trial) {
    int told[2];
    ASSERT_EQ(pipe(told), 0);
    const pid_t writer = fork();
    if (writer == 0) {
      for (int k = 1;; ++k) {
        write_state_file(path, {"", static_cast<double>(k), 0, std::string(1u << 18u, static_cast<char>(k)), ""});
        if (write(told[1], &k, sizeof k) != sizeof k) _exit(1);
      }
    }
    close(told[1]);
    int last = 0, k = 0;
    ASSERT_EQ(read(told[0], &k, sizeof k), static_cast<ssize_t>(sizeof k));
    usleep(random() % 20000);
    kill(writer, SIGKILL);
    waitpid(writer, nullptr, 0);
    for (last = k; read(told[0], &k, sizeof k) == static_cast<ssize_t>(sizeof k);) last = k;
    close(told[0]);
    const SavedState found = read_state_file(path);
    EXPECT_GE(found.time, last);
    EXPECT_EQ(found.world, std::string(1u << 18u, static_cast<char>(static_cast<int>(found.time))));
  }
}

}  // namespace
}  // namespace deformable_sim
