// Visual surfaces of bodies, from the scene to the skin.
#include <gtest/gtest.h>

#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

const std::string kData = DEFORMABLE_SIM_SOURCE_DIR "/test/scene/data/";

std::shared_ptr<const Model> model_of(const std::string& body) {
  return build_model(load_scene_text("bodies:\n  - " + body + "\n", "s.yaml"));
}

TEST(Visual, IsAbsentUnlessAskedFor) {
  EXPECT_EQ(model_of("cloth: {name: a}")->bodies[0].skin, nullptr);
  EXPECT_EQ(model_of("cloth: {name: a, visual: {upsample: 1}}")->bodies[0].skin, nullptr);
  EXPECT_EQ(model_of("soft: {name: a, box: {size: [0.1, 0.1, 0.1]}}")->bodies[0].skin, nullptr);
}

TEST(Visual, UpsamplesAGrid) {
  const auto model = model_of("cloth: {name: a, cells: [4, 3], visual: {upsample: 5}}");
  ASSERT_TRUE(model->bodies[0].skin);
  EXPECT_EQ(model->bodies[0].skin->surface().cols, 21);
  EXPECT_EQ(model->bodies[0].skin->surface().rows, 16);
  EXPECT_EQ(model->node_count(), 20);
}

TEST(Visual, MeshesRideOnClothAndSoftBodies) {
  // quad.obj, 2 x 1 and 0.5 up, a tenth of that: at rest the skin lies where the file says, in the frame of the body.
  const std::string visual = "visual: {mesh: " + kData + "quad.obj, mesh_scale: 0.1}";
  for (const std::string& body : {std::string("cloth: {name: a, size: [0.4, 0.4], pose: {position: [1, 2, 3]}, "),
                                  std::string("soft: {name: a, box: {size: [0.4, 0.4, 0.1]}, pose: {position: [1, 2, "
                                              "3]}, ")}) {
    const auto model = model_of(body + visual + "}");
    const Body& built = model->bodies[0];
    ASSERT_TRUE(built.skin) << body;
    ASSERT_EQ(built.skin->vertex_count(), 4);
    const Nodes shown = built.skin->positions(model->initial.x.leftCols(built.node_count));
    EXPECT_LT((shown - (built.skin->surface().rest.colwise() + Vec3(1, 2, 3))).cwiseAbs().maxCoeff(), 1e-12) << body;
  }
}

TEST(Visual, RefusalsNameTheKey) {
  const auto refusal = [](const std::string& body) {
    try {
      model_of(body);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal("cloth: {name: a, visual: {mesh: /nowhere.obj}}").find("s.yaml:2: bodies[0].cloth.visual.mesh: "),
            0u);
  EXPECT_EQ(refusal("soft: {name: a, box: {size: [1, 1, 1]}, visual: {mesh: /nowhere.obj}}")
                .find("s.yaml:2: bodies[0].soft.visual.mesh: "),
            0u);
  EXPECT_EQ(refusal("cloth: {name: a, visual: {upsample: 2, mesh: /nowhere.obj}}")
                .find("s.yaml:2: bodies[0].cloth.visual.mesh: excludes upsample"),
            0u);
  EXPECT_EQ(refusal("soft: {name: a, box: {size: [1, 1, 1]}, visual: {upsample: 2}}")
                .find("s.yaml:2: bodies[0].soft.visual.upsample: unknown key"),
            0u);
}

}  // namespace
}  // namespace deformable_sim
