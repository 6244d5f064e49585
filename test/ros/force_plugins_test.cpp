// Forces of another package: found by name, exact, refused at their line, and alive as long as the world they are in.
#include "deformable_sim/ros/force_plugins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/derivative_harness.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

const std::string kExample = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/examples/force_plugin";

class Forces : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const char* path = std::getenv("ROS_PACKAGE_PATH");
    setenv("ROS_PACKAGE_PATH", (kExample + (path ? ":" + std::string(path) : "")).c_str(), 1);
  }
  static std::string refusal(const std::string& force) {
    try {
      build_world(load_scene_text("bodies:\n  - rope: {name: line}\nforces:\n  - " + force + "\n", "scene"), 1,
                  std::make_shared<ForcePlugins>());
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(Forces, OfAPluginHaveTheirDerivatives) {
  Nodes x(3, 3);
  x << 0.1, 0.3, -0.2, 0.2, 0.1, 0.4, 0.5, -0.1, 0.3;
  const auto model = test::points_model(x, 1.0, Vec3::Zero());
  ForcePlugins plugins;
  const auto term =
      plugins.make({"force_plugin/Magnet", "", {{"position", {0.0, 0.1, 0.2}}, {"strength", {2.0}}}}, *model);
  EXPECT_EQ(term->name(), "magnet");
  EXPECT_EQ(term->element_count(), 3);
  State s = model->initial;
  test::check_derivatives(term.get(), s, true);
  // f = strength r / (r^2 + reach^2)^(3/2), towards the point.
  const Vec3 r = Vec3(0.0, 0.1, 0.2) - x.col(0);
  EXPECT_LT((test::force_of(*term, s).col(0) - 2.0 * r * std::pow(r.squaredNorm() + 1e-4, -1.5)).norm(), 1e-12);
}

TEST_F(Forces, MoveTheBodyThatTheSceneNamesAlone) {
  // Two ropes without weight: the one that is named is drawn to the point, the other stays. The plugin and its library
  // outlive the last hand on them.
  const std::string scene =
      "gravity: [0, 0, 0]\n"
      "bodies:\n"
      "  - rope: {name: near, length: 0.2, segments: 4}\n"
      "  - rope: {name: other, length: 0.2, segments: 4, pose: {position: [0, 1, 0]}}\n"
      "forces:\n"
      "  - {plugin: force_plugin/Magnet, body: near, parameters: {position: [0, 0, 0.5], strength: 1.0e-3}}\n";
  std::unique_ptr<World> world = build_world(load_scene_text(scene, "scene"), 1, std::make_shared<ForcePlugins>());
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(world->step().ok);
  const Model& model = world->model();
  EXPECT_GT((world->state().x - model.initial.x).row(2).head(5).minCoeff(), 1e-4);
  EXPECT_EQ((world->state().x - model.initial.x).rightCols(5).cwiseAbs().maxCoeff(), 0.0);
  world.reset();
}

TEST_F(Forces, AreRefusedAtTheirLine) {
  EXPECT_EQ(refusal("{plugin: force_plugin/Magnet, parameters: {position: [0, 0, 1], strength: 1}}"), "");
  EXPECT_EQ(refusal("{plugin: nobody/Knows}"),
            "scene:4: forces[0]: no package exports a force 'nobody/Knows'; there is force_plugin/Magnet");
  EXPECT_EQ(refusal("{plugin: force_plugin/Magnet, parameters: {position: [0, 0, 1]}}"),
            "scene:4: forces[0]: parameters.strength: must be more than 0");
  EXPECT_EQ(refusal("{plugin: force_plugin/Magnet, parameters: {strength: 1, position: [0, 1]}}"),
            "scene:4: forces[0]: parameters.position: must be given as [x, y, z]");
  EXPECT_EQ(refusal("{plugin: force_plugin/Magnet, parameters: {strenght: 1}}"),
            "scene:4: forces[0]: parameters.strenght: no such parameter; there is position, strength, reach");
  EXPECT_EQ(refusal("{plugin: force_plugin/Magnet, body: cloth}"),
            "scene:4: forces[0].body: no body 'cloth'; there is line");
  EXPECT_NE(refusal("{body: line}").find("plugin"), std::string::npos);
}

}  // namespace
}  // namespace deformable_sim
