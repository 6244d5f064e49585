// How bodies are drawn, from the scene to the model; and that nothing of it reaches the simulation.
#include <gtest/gtest.h>

#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/sheet_cut.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

std::shared_ptr<const Model> model_of(const std::string& body) {
  return build_model(load_scene_text("bodies:\n  - " + body + "\n", "s.yaml"));
}

std::string refusal(const std::string& text) {
  try {
    build_model(load_scene_text(text, "s.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Look, IsAbsentUnlessAskedFor) {
  EXPECT_EQ(model_of("cloth: {name: a}")->bodies[0].look, nullptr);
  EXPECT_EQ(model_of("cloth: {name: a, look: {}}")->bodies[0].look, nullptr);
  EXPECT_EQ(model_of("cloth: {name: a, look: {thickness: 0, seams: 0}}")->bodies[0].look, nullptr);
}

TEST(Look, TakesWhatTheSceneSays) {
  const auto model = model_of(
      "cloth: {name: a, size: [0.4, 0.4], cells: [4, 4], color: [0.4, 0.1, 1], material: {thickness: 0.002},"
      " look: {checker: 0.1, thickness: material}}");
  const auto look = model->bodies[0].look;
  ASSERT_TRUE(look);
  EXPECT_EQ(look->thickness, 0.002);
  EXPECT_EQ(look->cut.pieces.size(), 32u);
  EXPECT_NEAR(look->checker_color[0], 0.8, 1e-12);
  EXPECT_NEAR(look->checker_color[1], 0.7, 1e-12);
  const auto given = model_of("cloth: {name: a, look: {checker: 0.1, checker_color: [1, 0, 0.5], thickness: 0.003}}");
  EXPECT_EQ(given->bodies[0].look->checker_color, (std::array<double, 3>{{1, 0, 0.5}}));
  EXPECT_EQ(given->bodies[0].look->thickness, 0.003);
  EXPECT_EQ(model_of("rope: {name: a, model: rod, look: {stripe: 0.4}}")->bodies[0].stripe, 0.4);
}

TEST(Look, PaintsTheSkinWhereThereIsOne) {
  const auto model = model_of("cloth: {name: a, cells: [4, 4], visual: {upsample: 5}, look: {thickness: 0.001}}");
  EXPECT_EQ(model->bodies[0].look->cut.pieces.size(), 2u * 400u);
  EXPECT_EQ(model->bodies[0].look->cut.rims.size(), 4u * 20u);
}

TEST(Look, LeavesTheSimulationAsItIs) {
  // The same bits with and without.
  const std::string scene = "bodies:\n  - cloth: {name: a, cells: [6, 5], pins: [corner_0]";
  const std::string outputs = "}\noutputs: {shadows: true, contact_arrows: true, color_by: strain}\n";
  const auto plain = build_world(load_scene_text(scene + "}\n", "s.yaml"));
  const auto painted = build_world(
      load_scene_text(scene + ", look: {checker: 0.07, seams: 0.02, thickness: 0.003}" + outputs, "s.yaml"));
  for (int k = 0; k < 20; ++k) {
    plain->step();
    painted->step();
  }
  EXPECT_EQ(plain->snapshot().x, painted->snapshot().x);
}

struct LookRefusal {
  const char* name;
  std::string body, message;
};

TEST(Look, IsRefusedWithPlaceAndRange) {
  const std::string cloth = "cloth: {name: a, look: ", rope = "rope: {name: a, look: ",
                    rod = "rope: {name: a, model: rod, look: ";
  for (const LookRefusal& wrong : std::vector<LookRefusal>{
           {"squares", cloth + "{checker: 0}}",
            "bodies[0].cloth.look.checker: 0 is out of range; allowed: 0.001 ... 100"},
           {"no number", cloth + "{checker: .nan}}", "bodies[0].cloth.look.checker: "},
           {"too many squares", "cloth: {name: a, size: [50, 50], look: {checker: 0.001}}",
            "bodies[0].cloth.look: cuts the sheet into more than 100000 pieces"},
           {"colour of none", cloth + "{checker_color: [1, 1, 1]}}",
            "bodies[0].cloth.look.checker_color: belongs to checker"},
           {"colour", cloth + "{checker: 1, checker_color: [1, 1, 2]}}", "bodies[0].cloth.look.checker_color"},
           {"seams", cloth + "{seams: -1}}", "bodies[0].cloth.look.seams: -1 is out of range; allowed: 0 ... 1"},
           {"thickness", cloth + "{thickness: thick}}", "bodies[0].cloth.look.thickness: "},
           {"thickness of NaN", cloth + "{thickness: .nan}}", "bodies[0].cloth.look.thickness: "},
           {"stripe of a cloth", cloth + "{stripe: 0.5}}", "bodies[0].cloth.look.stripe: unknown key"},
           {"stripe without twist", rope + "{stripe: 0.5}}", "bodies[0].rope.look.stripe: belongs to model: rod"},
           {"stripe", rod + "{stripe: 1.5}}", "bodies[0].rope.look.stripe: 1.5 is out of range; allowed: 0 ... 1"},
           {"look of a soft body", "soft: {name: a, box: {size: [1, 1, 1]}, look: {}}",
            "bodies[0].soft.look: unknown key"},
       }) {
    const std::string found = refusal("bodies:\n  - " + wrong.body + "\n");
    EXPECT_EQ(found.find("s.yaml:2: " + wrong.message), 0u) << wrong.name << ": " << found;
  }
  const std::string bodies = "bodies:\n  - cloth: {name: a}\n";
  for (const LookRefusal& wrong : std::vector<LookRefusal>{
           {"shadows", "{shadows: dark}", "outputs.shadows: must be true or false"},
           {"arrows", "{contact_arrows: 1}", "outputs.contact_arrows: must be true or false"},
           {"scale", "{contact_scale: 0}", "outputs.contact_scale: 0 is out of range; allowed: > 0, <= 1"},
           {"scale of NaN", "{contact_scale: .nan}", "outputs.contact_scale: "},
           {"place of the legend", "{legend_position: [0, 0]}", "outputs.legend_position: "},
           {"legend at infinity", "{legend_position: [0, 0, .inf]}", "outputs.legend_position"},
           {"height", "{legend_height: -1}", "outputs.legend_height: -1 is out of range"},
       }) {
    const std::string found = refusal(bodies + "outputs: " + wrong.body + "\n");
    EXPECT_EQ(found.find("s.yaml:3: " + wrong.message), 0u) << wrong.name << ": " << found;
  }
}

}  // namespace
}  // namespace deformable_sim
