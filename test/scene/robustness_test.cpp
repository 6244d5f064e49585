// Text that no one meant: whatever it is, the loader returns a scene or an InputError.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kScene =
    "title: everything at once\n"
    "gravity: [0, 0, -9.81]\n"
    "air: {density: 1.2, drag_coefficient: 1, wind: [1, 0, 0], gust_amplitude: 0.2}\n"
    "step: {dt: 0.005, integrator: implicit_euler, linear_solver: direct, newton_iterations: 4}\n"
    "bodies:\n"
    "  - cloth: {name: a, pose: &p {position: [0, 0, 1], rpy: [0, 0.1, 0]}, size: [1, 1], cells: [4, 4],\n"
    "            material: {areal_density: 0.2, stretch_stiffness: 50}, pins: [corner_0, edge_2]}\n"
    "  - rope:\n"
    "      name: b\n"
    "      pose: *p\n"
    "      segments: 12\n"
    "      color: [0.1, 0.2, 0.3]\n"
    "colliders:\n"
    "  - box: {name: table, size: [1, 1, 0.1], friction: 0.3}\n"
    "  - capsule: {name: bar, radius: 0.1, length: 1, frame: \"tool\"}\n"
    "grasps:\n"
    "  - {name: g, body: b, select: {feature: end_0}, max_force: 3}\n"
    "  - {name: h, body: a, select: {radius: 0.1, center: [0, 0, 1]}, pose: {position: [0, 0, 1]}}\n"
    "robot: {links: [hand]}\n"
    "outputs: {color_by: strain, wireframe: true}\n";

/// One line of UTF-8, as ROS clients in Python insist on: continuation bytes follow where the first byte promises them.
bool is_one_clean_line(const std::string& text) {
  size_t due = 0;
  for (const unsigned char c : text) {
    if (due > 0) {
      if ((c & 0xc0) != 0x80) return false;
      --due;
    } else if (c < 0x20 || c == 0x7f || (c >= 0x80 && c < 0xc2) || c > 0xf4) {
      return false;
    } else {
      due = c < 0x80 ? 0 : c < 0xe0 ? 1 : c < 0xf0 ? 2 : 3;
    }
  }
  return due == 0;
}

/// Loads; anything but a scene or an InputError with a one-line message fails the test.
bool accepted(const std::string& text) {
  try {
    load_scene_text(text, "s.yaml");
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("s.yaml:", 0), 0u) << error.what();
    EXPECT_TRUE(is_one_clean_line(error.what())) << error.what();
    EXPECT_LT(std::string(error.what()).size(), 1000u);
  }
  return false;
}

TEST(SceneText, LoadsAsAWhole) {
  EXPECT_TRUE(accepted(kScene));
}

TEST(SceneText, CutAnywhereIsLoadedOrRefused) {
  int refused = 0;
  for (size_t n = 0; n < kScene.size(); ++n) refused += accepted(kScene.substr(0, n)) ? 0 : 1;
  // Bodies come late: at least every cut before them is refused.
  EXPECT_GT(refused, static_cast<int>(kScene.find("name: a")));
}

TEST(SceneText, WithAnyByteChangedIsLoadedOrRefused) {
  std::mt19937 random(20240601);
  int refused = 0;
  for (int round = 0; round < 4000; ++round) {
    std::string text = kScene;
    text[random() % text.size()] = static_cast<char>(random() % 256);
    refused += accepted(text) ? 0 : 1;
  }
  EXPECT_GT(refused, 1000);
}

TEST(SceneText, MadeOfNoiseIsRefused) {
  std::mt19937 random(7);
  for (int round = 0; round < 500; ++round) {
    std::string text(random() % 200 + 1, ' ');
    for (char& c : text) c = "{}[],:-?&*!|>'\"%@#\n \tab0.\\~"[random() % 28];
    accepted(text);
  }
}

std::string repeated(const std::string& part, size_t count) {
  std::string text;
  for (size_t k = 0; k < count; ++k) text += part;
  return text;
}

TEST(SceneText, NestedDeeplyIsRefused) {
  EXPECT_FALSE(accepted(repeated("[", 40)));
  EXPECT_FALSE(accepted(repeated("[", 100000)));
  EXPECT_FALSE(accepted(repeated("{a: ", 100000)));
  EXPECT_FALSE(accepted(repeated("- ", 20000)));
}

TEST(SceneText, WithAliasesOfAliasesIsRefusedBeforeItFillsTheMemory) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int k = 1; k < 20; ++k) {
    const std::string last = "*a" + std::to_string(k - 1);
    text += "a" + std::to_string(k) + ": &a" + std::to_string(k) + " [" + repeated(last + ", ", 9) + last + "]\n";
  }
  EXPECT_FALSE(accepted(text));
  // One long text, many times.
  EXPECT_FALSE(accepted("a: &a '" + std::string(1u << 20, 'x') + "'\nb: [" + repeated("*a, ", 50000) + "]\n"));
}

TEST(SceneText, BeyondTheLimitIsRefused) {
  EXPECT_FALSE(accepted(std::string((4u << 20) + 1, '#')));
  EXPECT_FALSE(accepted("title: " + std::string(1u << 20, 'x') + "\n"));
  EXPECT_FALSE(accepted(std::string(1u << 20, 'k') + ": 1\n"));
}

}  // namespace
}  // namespace deformable_sim
