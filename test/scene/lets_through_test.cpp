// The scene keys that say which colliders let which bodies through.
#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kBodies = "bodies:\n  - cloth: {name: towel}\n  - rope: {name: line}\n";

TEST(LetsThroughKeys, AreReadForCollidersAndLinks) {
  const SceneSpec spec = load_scene_text(
      "robot: {lets_through: {left: [towel], right: [towel, line]}}\n" + kBodies +
          "colliders:\n  - plane: {name: floor, lets_through: [line]}\n  - sphere: {name: ball, radius: 0.1}\n",
      "s");
  EXPECT_EQ(spec.colliders[0].collider.lets_through, std::vector<std::string>{"line"});
  EXPECT_TRUE(spec.colliders[1].collider.lets_through.empty());
  EXPECT_EQ(spec.robot.lets_through.at("left"), std::vector<std::string>{"towel"});
  EXPECT_EQ(spec.robot.lets_through.at("right"), (std::vector<std::string>{"towel", "line"}));
}

TEST(LetsThroughKeys, NameBodiesThatExist) {
  const auto message = [](const std::string& rest) -> std::string {
    try {
      load_scene_text(kBodies + rest, "s");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("colliders:\n  - plane: {name: floor, lets_through: [line, lime]}\n"),
            "s:5: colliders[0].plane.lets_through[1]: no body 'lime'; there is towel, line");
  EXPECT_EQ(message("robot:\n  lets_through:\n    hand: [shirt]\n"),
            "s:6: robot.lets_through.hand[0]: no body 'shirt'; there is towel, line");
  EXPECT_EQ(message("robot: {lets_through: hand}\n"),
            "s:4: robot.lets_through: must be a map of links and lists of bodies");
}

}  // namespace
}  // namespace deformable_sim
