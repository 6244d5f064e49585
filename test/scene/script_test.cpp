// What a scene does by itself: read, refused and played.
#include "deformable_sim/scene/script.h"

#include <gtest/gtest.h>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kScene =
    "gravity: [0, 0, 0]\n"
    "step: {dt: 0.01, integrator: implicit_euler}\n"
    "bodies:\n"
    "  - rope: {name: rope, length: 1, segments: 10, pins: [end_0]}\n"
    "colliders:\n"
    "  - box: {name: finger, size: [0.1, 0.1, 0.1], pose: {position: [0, 0, 5]}}\n"
    "  - box: {name: link, size: [0.1, 0.1, 0.1], frame: hand, pose: {position: [0, 0, 7]}}\n"
    "script:\n";

TEST(SceneScript, GraspsMovesAndReleasesAtItsTimes) {
  // The finger goes 0.2 m in 0.1 s from t = 0.05 s on; the end of the rope follows its grasp by 0.1 m and is let go.
  const SceneSpec spec =
      load_scene_text(kScene +
                          "  - {at: 0.05, move_collider: finger, duration: 0.1,\n"
                          "     pose: {position: [0, 0, 5.2]}}\n"
                          "  - {at: 0.05, grasp: {name: hand, body: rope, select: {feature: end_1},\n"
                          "     pose: {position: [0.5, 0, 0]}}}\n"
                          "  - {at: 0.05, move_grasp: hand, duration: 0.1,\n"
                          "     pose: {position: [0.4, 0, 0]}}\n"
                          "  - {at: 0.2, release: hand}\n",
                      "s.yaml");
  const auto world = build_world(spec);
  Script script(spec.script);
  for (int round = 0; round < 2; ++round) {
    const auto run_to = [&](double time) {
      while (world->time() < time - 1e-9) {
        const Reply reply = play(&script, world.get());
        ASSERT_TRUE(reply.status.ok()) << reply.status.message;
        ASSERT_TRUE(world->step().ok);
      }
    };
    run_to(0.05);
    EXPECT_EQ(world->snapshot().grasps.size(), 1u);
    run_to(0.1);
    EXPECT_NEAR(world->snapshot().colliders[0].world_from_collider.translation().z(), 5.1, 1e-12);
    EXPECT_NEAR(world->state().x(0, 10), 0.45, 1e-12);
    EXPECT_EQ(world->snapshot().grasps.size(), 2u);
    run_to(0.2);
    EXPECT_NEAR(world->snapshot().colliders[0].world_from_collider.translation().z(), 5.2, 1e-12);
    EXPECT_NEAR(world->state().x(0, 10), 0.4, 1e-12);
    run_to(0.21);
    EXPECT_EQ(world->snapshot().grasps.size(), 1u);
    ASSERT_TRUE(world->apply(command::Reset{}).status.ok());
    script.restart();
  }
}

TEST(SceneScript, SaysWhatIsRefusedWhileItPlays) {
  // Two grasps of one node: known only when they are made.
  const SceneSpec spec =
      load_scene_text(kScene + "  - {at: 0, grasp: {name: hand, body: rope, select: {feature: end_0}}}\n", "s.yaml");
  const auto world = build_world(spec);
  Script script(spec.script);
  const Reply reply = play(&script, world.get());
  EXPECT_FALSE(reply.status.ok());
  EXPECT_EQ(reply.status.message.find("s.yaml:9: script[0]: at 0 s: "), 0u) << reply.status.message;
}

TEST(SceneScript, NotesMovesThatAreTooFast) {
  const SceneSpec spec = load_scene_text(
      kScene + "  - {at: 0, move_collider: finger, duration: 0.1, pose: {position: [0, 0, 9]}}\n", "s.yaml");
  const auto world = build_world(spec);
  Script script(spec.script);
  const Reply reply = play(&script, world.get());
  EXPECT_TRUE(reply.status.ok());
  EXPECT_EQ(reply.note.find("s.yaml:9: script[0]: at 0 s: rate-limited"), 0u) << reply.note;
}

std::string refusal(const std::string& event) {
  try {
    load_scene_text(kScene + "  - {at: 1, release: pin_rope_end_0}\n" + "  - {" + event + "}\n", "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

TEST(SceneScript, RefusesWhatCannotBe) {
  EXPECT_EQ(refusal("at: 1, release: pin_rope_end_0"), "(accepted)");
  for (const auto& [event, message] : std::vector<std::pair<std::string, std::string>>{
           {"release: pin_rope_end_0", "s.yaml:10: script[1].at: required"},
           {"at: 0.9, release: pin_rope_end_0", "s.yaml:10: script[1].at: is before that of the event before, 1"},
           {"at: 1", "s.yaml:10: script[1]: needs exactly one of grasp, release, move_grasp, move_collider"},
           {"at: 1, release: hand", "s.yaml:10: script[1].release: no grasp 'hand'; there is pin_rope_end_0"},
           {"at: 1, move_grasp: hand, pose: {}", "s.yaml:10: script[1].move_grasp: no grasp 'hand'"},
           {"at: 1, move_collider: hand, pose: {}", "s.yaml:10: script[1].move_collider: no collider 'hand'"},
           {"at: 1, move_collider: link, pose: {}", "s.yaml:10: script[1].move_collider: 'link' follows tf frame hand"},
           {"at: 1, move_collider: finger", "s.yaml:10: script[1].pose: required by a move"},
           {"at: 1, release: pin_rope_end_0, pose: {}", "s.yaml:10: script[1].pose: belongs to move_grasp"},
           {"at: 1, release: pin_rope_end_0, duration: 2", "s.yaml:10: script[1].duration: belongs to move_grasp"},
           {"at: 1, grasp: {name: hand, body: towel, select: {feature: end_1}}",
            "s.yaml:10: script[1].grasp.body: no body 'towel'"},
           {"at: 1, grasp: {name: hand, body: rope, select: {feature: end_2}}",
            "s.yaml:10: script[1].grasp.select.feature: 'rope' has no feature 'end_2'"}}) {
    EXPECT_EQ(refusal(event).rfind(message, 0), 0u) << event << ": " << refusal(event);
  }
}

}  // namespace
}  // namespace deformable_sim
