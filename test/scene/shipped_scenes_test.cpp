// Every scene in config/scenes is loaded, stepped, and stays sane.
#include <gtest/gtest.h>

#include "deformable_sim/core/contact/contact_finder.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/script.h"

namespace deformable_sim {
namespace {

const std::string kScenes = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/config/scenes";

class ShippedScene : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScene, StepsWithoutPenetrationOrTearing) {
  // Nodes, middles of edges and centroids of faces stay out of every collider: no deeper than 1 mm at any time.
  const SceneSpec spec = load_scene_file(find_scene(GetParam(), kScenes));
  EXPECT_FALSE(spec.title.empty() && GetParam() != "minimal") << "a shipped scene says what it shows";
  const std::unique_ptr<World> world = build_world(spec);
  Script script(spec.script);
  double depth = 0.0, strain = 0.0;
  while (world->time() < 1.0) {
    const Reply reply = play(&script, world.get());
    ASSERT_TRUE(reply.status.ok()) << reply.status.message;
    const StepOutcome outcome = world->step();
    ASSERT_TRUE(outcome.ok) << "at " << world->time() << " s: " << outcome.message;
    if (world->step_count() % 5 != 0) continue;
    const Snapshot now = world->snapshot();
    ASSERT_TRUE(world->state().finite());
    depth = std::max(depth, measure_penetration(*now.model, now.colliders, now.x));
    for (const BodyReport& body : now.bodies) strain = std::max(strain, body.max_strain);
  }
  EXPECT_LT(depth, 0.001) << "m";
  // A point-pinned corner of soft cloth carries a few per cent; far more means a torn or unstable sheet.
  EXPECT_LT(strain, 0.25);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, testing::ValuesIn(scene_names(kScenes)),
                         [](const testing::TestParamInfo<std::string>& info) { return info.param; });

TEST(ShippedScenes, AreAtLeastTen) {
  EXPECT_GE(scene_names(kScenes).size(), 10u);
}

}  // namespace
}  // namespace deformable_sim
