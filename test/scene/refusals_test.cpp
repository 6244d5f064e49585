// Every refusal of a scene names the file, the line, the key, what is wrong and what is allowed.
#include <gtest/gtest.h>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

struct Refusal {
  const char* title;
  std::string yaml;
  const char* message;  // beginning of the message after the origin
};

void PrintTo(const Refusal& refusal, std::ostream* out) {
  *out << refusal.title;
}

/// A good scene of 13 lines, for single changes.
const std::string kCloth =
    "bodies:\n"
    "  - cloth:\n"
    "      name: sheet\n"
    "      cells: [3, 2]\n"
    "      material:\n"
    "        thickness: 0.001\n";
const std::string kMeshDir = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/test/scene/data/";

std::string refusal_of(const std::string& yaml, const std::vector<Override>& overrides = {}) {
  try {
    build_world(load_scene_text(yaml, "s.yaml", overrides));
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

class SceneRefusals : public testing::TestWithParam<Refusal> {};

TEST_P(SceneRefusals, NameFileLineKeyAndWhatIsAllowed) {
  const std::string message = refusal_of(GetParam().yaml);
  EXPECT_EQ(message.rfind(GetParam().message, 0), 0u)
      << "expected: " << GetParam().message << "\ngot:      " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << "one line";
}

std::string in_body(const std::string& line) {
  return kCloth + "      " + line + "\n";
}
std::string in_material(const std::string& line) {
  return kCloth + "        " + line + "\n";
}
std::string with(const std::string& lines) {
  return kCloth + lines;
}

INSTANTIATE_TEST_SUITE_P(Forces, SceneRefusals,
                         testing::Values(Refusal{"WithoutPlugins", kCloth + "forces:\n  - {plugin: a/B}\n",
                                                 "s.yaml:8: forces[0]: only the node loads plugins"},
                                         Refusal{"OfNoBody", kCloth + "forces:\n  - {plugin: a/B, body: shirt}\n",
                                                 "s.yaml:8: forces[0].body: no body 'shirt'; there is sheet"},
                                         Refusal{"WithWords",
                                                 kCloth + "forces:\n  - {plugin: a/B, parameters: {at: [1, here]}}\n",
                                                 "s.yaml:8: forces[0].parameters.at[1]: must be a number, not 'here'"},
                                         Refusal{"WithoutName", kCloth + "forces:\n  - {body: sheet}\n",
                                                 "s.yaml:8: forces[0].plugin: required, and missing"}),
                         [](const auto& info) { return std::string(info.param.title); });

INSTANTIATE_TEST_SUITE_P(
    Text, SceneRefusals,
    testing::Values(
        Refusal{"empty", "", "s.yaml:1: the scene is empty"},
        Refusal{"only a comment", "# nothing\n", "s.yaml:1: the scene is empty"},
        Refusal{"null", "~\n", "s.yaml:1: the scene is empty"},
        Refusal{"a list", "- 1\n", "s.yaml:1: must be a map, not a list"},
        Refusal{"a word", "hello\n", "s.yaml:1: must be a map, not 'hello'"},
        Refusal{"truncated flow", "bodies:\n  - cloth: {name: a, cells: [3,\n", "s.yaml:3: not valid YAML: "},
        Refusal{"bad indentation", "bodies:\n  - cloth:\n name: a\n", "s.yaml:3: not valid YAML: "},
        Refusal{"tab", "bodies:\n\t- cloth: {name: a}\n", "s.yaml:2: not valid YAML: "},
        Refusal{"two documents", kCloth + "---\n" + kCloth, "s.yaml:7: a second document; a scene is one"},
        Refusal{"key twice", in_body("name: other"), "s.yaml:7: name: given twice; the first is at line 3"},
        Refusal{"top key twice", with("bodies: []\n"), "s.yaml:7: bodies: given twice; the first is at line 1"},
        Refusal{"list as key", "? [a]\n: 1\n", "s.yaml:1: a key must be a plain word"},
        Refusal{"alias in itself", "bodies: &a [*a]\n", "s.yaml:1: an alias inside the value it stands for"},
        Refusal{"unknown alias", "bodies: *a\n", "s.yaml:1: not valid YAML: "}));

INSTANTIATE_TEST_SUITE_P(
    Keys, SceneRefusals,
    testing::Values(
        Refusal{"unknown top key", with("gravty: [0, 0, 0]\n"),
                "s.yaml:7: gravty: unknown key; did you mean 'gravity'? Allowed: title, gravity, air, step"},
        Refusal{"unknown nested key", in_material("thicknes: 1"),
                "s.yaml:7: bodies[0].cloth.material.thicknes: unknown key; did you mean 'thickness'?"},
        Refusal{"unknown key, none near", in_body("zzzzzz: 1"),
                "s.yaml:7: bodies[0].cloth.zzzzzz: unknown key; allowed: "},
        Refusal{"no bodies", "title: x\n", "s.yaml:1: bodies: required, and missing"},
        Refusal{"empty bodies", "bodies: []\n", "s.yaml:1: bodies: must hold at least one body"},
        Refusal{"bodies null", "title: x\nbodies:\n", "s.yaml:2: bodies: must be a list of bodies, not nothing"},
        Refusal{"bodies map", "bodies: {a: 1}\n", "s.yaml:1: bodies: must be a list of bodies, not a map"},
        Refusal{"unknown kind", "bodies:\n  - clot: {name: a}\n",
                "s.yaml:2: bodies[0].clot: unknown key; did you mean 'cloth'? Allowed: cloth, rope"},
        Refusal{"two kinds", "bodies:\n  - cloth: {name: a}\n    rope: {name: b}\n",
                "s.yaml:2: bodies[0]: must be a map with one key, one of cloth, rope"},
        Refusal{"no name", "bodies:\n  - cloth:\n      cells: [2, 2]\n",
                "s.yaml:3: bodies[0].cloth.name: required, and missing; allowed: a-z, 0-9, _"},
        Refusal{"body null", "bodies:\n  - cloth:\n", "s.yaml:2: bodies[0].cloth: must be a map, not nothing"},
        Refusal{"collider without size", with("colliders:\n  - box: {name: b}\n"),
                "s.yaml:8: colliders[0].box.size: required, and missing; allowed: 0.0001 ... 1000"},
        Refusal{"unknown collider", with("colliders:\n  - ball: {name: b}\n"),
                "s.yaml:8: colliders[0].ball: unknown key; allowed: box, sphere, cylinder, capsule, plane, cone, mesh"},
        Refusal{"mesh collider without file", with("colliders:\n  - mesh: {name: m}\n"),
                "s.yaml:8: colliders[0].mesh.file: required, and missing"},
        Refusal{"mesh collider of no file", with("colliders:\n  - mesh: {name: m, file: /no/such.stl}\n"),
                "s.yaml:8: colliders[0].mesh.file: /no/such.stl: no such mesh file"},
        Refusal{"open mesh collider", with("colliders:\n  - mesh: {name: m, file: '" + kMeshDir + "quad.obj'}\n"),
                "s.yaml:8: colliders[0].mesh.file: "},
        Refusal{"robot of negative padding", with("robot: {padding: -0.1}\n"),
                "s.yaml:7: robot.padding: -0.1 is out of range; allowed: 0 ... 1"},
        Refusal{"grasp without body", with("grasps:\n  - name: g\n    select: {feature: center}\n"),
                "s.yaml:8: grasps[0].body: required, and missing"},
        Refusal{"grasp without select", with("grasps:\n  - name: g\n    body: sheet\n"),
                "s.yaml:8: grasps[0].select: required, and missing"},
        Refusal{"rpy and orientation", in_body("pose: {rpy: [0, 0, 0], orientation: [0, 0, 0, 1]}"),
                "s.yaml:7: bodies[0].cloth.pose.orientation: excludes rpy; give one"},
        Refusal{"mesh and cells", in_body("mesh: a.obj"), "s.yaml:4: bodies[0].cloth.cells: excludes mesh; give one"},
        Refusal{"select nothing", with("grasps:\n  - {name: g, body: sheet, select: {reach: 1}}\n"),
                "s.yaml:8: grasps[0].select: needs exactly one of feature, nodes, nearest, radius, box"},
        Refusal{"select two", with("grasps:\n  - {name: g, body: sheet, select: {nodes: [1], feature: center}}\n"),
                "s.yaml:8: grasps[0].select: needs exactly one of"},
        Refusal{"reach without nearest", with("grasps:\n  - {name: g, body: sheet, select: {nodes: [1], reach: 1}}\n"),
                "s.yaml:8: grasps[0].select.reach: belongs to nearest"},
        Refusal{"key for grids",
                "bodies:\n  - cloth:\n      name: a\n      mesh: a.obj\n      material: {shear_stiffness: 1}\n",
                "s.yaml:5: bodies[0].cloth.material.shear_stiffness: is for grids"}));

INSTANTIATE_TEST_SUITE_P(
    Values, SceneRefusals,
    testing::Values(
        Refusal{"word for number", in_material("damping: much"),
                "s.yaml:7: bodies[0].cloth.material.damping: must be a number, not 'much'"},
        Refusal{"number in quotes", in_material("damping: \"0.1\""),
                "s.yaml:7: bodies[0].cloth.material.damping: must be a number, not the quoted text '0.1'"},
        Refusal{"list for number", in_material("damping: [1]"),
                "s.yaml:7: bodies[0].cloth.material.damping: must be a number, not a list"},
        Refusal{"number with unit", in_material("damping: 0.1s"),
                "s.yaml:7: bodies[0].cloth.material.damping: must be a number, not '0.1s'"},
        Refusal{"hexadecimal", in_material("damping: 0x1"),
                "s.yaml:7: bodies[0].cloth.material.damping: must be a number"},
        Refusal{"nan", in_material("damping: .nan"),
                "s.yaml:7: bodies[0].cloth.material.damping: must be finite, not '.nan'; allowed: 0 ... 1"},
        Refusal{"inf", in_material("youngs_modulus: .inf"),
                "s.yaml:7: bodies[0].cloth.material.youngs_modulus: must be finite"},
        Refusal{"-inf in a vector", with("gravity: [0, 0, -.inf]\n"),
                "s.yaml:7: gravity[2]: must be finite, not '-.inf'"},
        Refusal{"beyond double", in_material("youngs_modulus: 1e999"),
                "s.yaml:7: bodies[0].cloth.material.youngs_modulus: must be"},
        Refusal{"negative stiffness", in_material("stretch_stiffness: -5"),
                "s.yaml:7: bodies[0].cloth.material.stretch_stiffness: -5 is out of range; allowed: > 0, <= 1e+09"},
        Refusal{"zero modulus", in_material("youngs_modulus: 0"),
                "s.yaml:7: bodies[0].cloth.material.youngs_modulus: 0 is out of range; allowed: 1 ... 1e+12"},
        Refusal{"poisson", in_material("poissons_ratio: 0.6"),
                "s.yaml:7: bodies[0].cloth.material.poissons_ratio: 0.6 is out of range; allowed: 0 ... 0.5"},
        Refusal{"short vector", with("gravity: [0, 0]\n"), "s.yaml:7: gravity: must be a list of 3 numbers, not of 2"},
        Refusal{"scalar for vector", with("gravity: -9.81\n"),
                "s.yaml:7: gravity: must be a list of 3 numbers, not '-9.81'"},
        Refusal{"second line of a vector", with("gravity:\n  - 0\n  - 0\n  - down\n"),
                "s.yaml:10: gravity[2]: must be a number, not 'down'"},
        Refusal{"fraction of a cell", "bodies:\n  - cloth: {name: a, cells: [2.5, 2]}\n",
                "s.yaml:2: bodies[0].cloth.cells[0]: must be a whole number, not '2.5'"},
        Refusal{"no cell", "bodies:\n  - cloth: {name: a, cells: [0, 2]}\n",
                "s.yaml:2: bodies[0].cloth.cells[0]: 0 is out of range; allowed: 1 ... 2000"},
        Refusal{"long integer", "bodies:\n  - cloth: {name: a, cells: [99999999999999999999, 2]}\n",
                "s.yaml:2: bodies[0].cloth.cells[0]: 99999999999999999999 is out of range"},
        Refusal{"zero dt", with("step: {dt: 0}\n"), "s.yaml:7: step.dt: 0 is out of range; allowed: 1e-09 ... 2"},
        Refusal{"integrator", with("step: {integrator: implict_euler}\n"),
                "s.yaml:7: step.integrator: unknown 'implict_euler'; did you mean 'implicit_euler'? Allowed: "},
        Refusal{"linear solver", with("step: {linear_solver: lu}\n"), "s.yaml:7: step.linear_solver: unknown 'lu'"},
        Refusal{"color_by", with("outputs: {color_by: blue}\n"), "s.yaml:7: outputs.color_by: unknown 'blue'"},
        Refusal{"bool", with("outputs: {wireframe: yes}\n"),
                "s.yaml:7: outputs.wireframe: must be true or false, not 'yes'"},
        Refusal{"colour", in_body("color: [0, 0, 2]"),
                "s.yaml:7: bodies[0].cloth.color[2]: 2 is out of range; allowed: 0 ... 1"},
        Refusal{"quaternion", in_body("pose: {orientation: [0, 0, 0, 0.5]}"),
                "s.yaml:7: bodies[0].cloth.pose.orientation: has length 0.5; a unit quaternion"},
        Refusal{"far pose", in_body("pose: {position: [0, 0, 1e6]}"),
                "s.yaml:7: bodies[0].cloth.pose.position[2]: 1e6 is out of range"},
        Refusal{"negative friction", in_body("friction: -1"),
                "s.yaml:7: bodies[0].cloth.friction: -1 is out of range; allowed: 0 ... 10"},
        Refusal{"negative rate", with("outputs: {rate_state: -1}\n"),
                "s.yaml:7: outputs.rate_state: -1 is out of range"},
        Refusal{"contact points", in_body("contact_points: edges"),
                "s.yaml:7: bodies[0].cloth.contact_points: unknown 'edges'"},
        Refusal{"empty title", with("title: ''\n"), "s.yaml:7: title: must not be empty"},
        Refusal{"grasp force", with("grasps:\n  - {name: g, body: sheet, select: {nodes: [1]}, max_force: -1}\n"),
                "s.yaml:8: grasps[0].max_force: -1 is out of range"},
        Refusal{"loop of two", "bodies:\n  - rope: {name: a, closed: true, segments: 2}\n",
                "s.yaml:2: bodies[0].rope.closed: a loop needs at least 3 segments"},
        Refusal{"too many nodes", "bodies:\n  - cloth: {name: a, cells: [2000, 2000]}\n",
                "s.yaml:2: bodies[0].cloth: 4.004e+06 nodes so far; at most 200000 in a scene"}));

INSTANTIATE_TEST_SUITE_P(
    Names, SceneRefusals,
    testing::Values(
        Refusal{"capital", "bodies:\n  - cloth: {name: Sheet}\n",
                "s.yaml:2: bodies[0].cloth.name: 'Sheet' is not a name; allowed: lower case"},
        Refusal{"digit first", "bodies:\n  - cloth: {name: 1a}\n",
                "s.yaml:2: bodies[0].cloth.name: '1a' is not a name"},
        Refusal{"slash", "bodies:\n  - cloth: {name: a/b}\n", "s.yaml:2: bodies[0].cloth.name: 'a/b' is not a name"},
        Refusal{"umlaut", "bodies:\n  - cloth: {name: tür}\n", "s.yaml:2: bodies[0].cloth.name: 'tür' is not a name"},
        Refusal{"body twice", kCloth + "  - rope: {name: sheet}\n",
                "s.yaml:7: bodies[1].rope.name: 'sheet' is taken by bodies[0].cloth.name"},
        Refusal{"collider twice", with("colliders:\n  - plane: {name: p}\n  - plane: {name: p}\n"),
                "s.yaml:9: colliders[1].plane.name: 'p' is taken by colliders[0].plane.name"},
        Refusal{"grasp twice",
                with("grasps:\n  - {name: g, body: sheet, select: {nodes: [1]}}\n  - {name: g, body: sheet, select: "
                     "{nodes: [2]}}\n"),
                "s.yaml:9: grasps[1].name: 'g' is taken by grasps[0].name"},
        Refusal{
            "grasp named as a pin",
            with(
                "      pins: [corner_0]\ngrasps:\n  - {name: pin_sheet_corner_0, body: sheet, select: {nodes: [1]}}\n"),
            "s.yaml:9: grasps[0].name: 'pin_sheet_corner_0' is taken by bodies[0].cloth.pins[0]"},
        Refusal{"pin twice", in_body("pins: [center, center]"),
                "s.yaml:7: bodies[0].cloth.pins[1]: 'pin_sheet_center' is taken by"},
        Refusal{"unknown feature", in_body("pins: [corner_0, corner_4]"),
                "s.yaml:7: bodies[0].cloth.pins[1]: 'sheet' has no feature 'corner_4'; it has corner_0, corner_1"},
        Refusal{"feature of a rope", "bodies:\n  - rope: {name: r, pins: [corner_0]}\n",
                "s.yaml:2: bodies[0].rope.pins[0]: 'r' has no feature 'corner_0'; it has end_0, end_1, center"},
        Refusal{"end of a loop", "bodies:\n  - rope: {name: r, closed: true, pins: [end_1]}\n",
                "s.yaml:2: bodies[0].rope.pins[0]: 'r' has no feature 'end_1'; it has end_0, center"},
        Refusal{"corner of a mesh", "bodies:\n  - cloth: {name: m, mesh: a.obj, pins: [corner_0]}\n",
                "s.yaml:2: bodies[0].cloth.pins[0]: 'm' has no feature 'corner_0'; it has center"},
        Refusal{"grasp of nobody", with("grasps:\n  - name: g\n    body: towel\n    select: {nodes: [1]}\n"),
                "s.yaml:9: grasps[0].body: no body 'towel'; there is sheet"},
        Refusal{"grasp of an unknown feature",
                with("grasps:\n  - name: g\n    body: sheet\n    select: {feature: end_0}\n"),
                "s.yaml:10: grasps[0].select.feature: 'sheet' has no feature 'end_0'"},
        Refusal{"grasp of an unknown node",
                with("grasps:\n  - name: g\n    body: sheet\n    select:\n      nodes: [12]\n"),
                "s.yaml:11: grasps[0].select: node 12 does not exist"},
        Refusal{"grasp of no node", with("grasps:\n  - {name: g, body: sheet, select: {nodes: []}}\n"),
                "s.yaml:8: grasps[0].select.nodes: must name at least one node"},
        Refusal{"grasp out of reach", with("grasps:\n  - {name: g, body: sheet, select: {nearest: [0, 0, 0.5]}}\n"),
                "s.yaml:8: grasps[0].select: no node of 'sheet' within 0.02 m"},
        Refusal{"two pins, one node", in_body("pins: [corner_0, edge_0]"),
                "s.yaml:7: bodies[0].cloth.pins: node 0 of 'sheet' is already held by 'pin_sheet_corner_0'"}));

std::string mesh_scene(const std::string& file) {
  return "bodies:\n  - cloth:\n      name: m\n      mesh: " + kMeshDir + file + "\n";
}

INSTANTIATE_TEST_SUITE_P(
    Meshes, SceneRefusals,
    testing::Values(
        Refusal{"missing file", "bodies:\n  - cloth:\n      name: m\n      mesh: nowhere.obj\n",
                "s.yaml:4: bodies[0].cloth.mesh: nowhere.obj: no such mesh file"},
        Refusal{"not a mesh format",
                "bodies:\n  - cloth:\n      name: m\n      mesh: " + std::string(DEFORMABLE_SIM_SOURCE_DIR) +
                    "/package.xml\n",
                "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"no faces", mesh_scene("no_faces.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"zero area", mesh_scene("degenerate.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"node twice in a face", mesh_scene("repeated.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"three faces on an edge", mesh_scene("non_manifold.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"inconsistent winding", mesh_scene("winding.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"vertex that does not exist", mesh_scene("missing_vertex.obj"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"vertex that is no number", mesh_scene("nan.ply"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"truncated", mesh_scene("truncated.ply"), "s.yaml:4: bodies[0].cloth.mesh: "},
        Refusal{"too many with the mesh",
                "bodies:\n  - cloth: {name: a, cells: [446, 446]}\n  - cloth: {name: b, mesh: " +
                    std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/meshes/tshirt.obj}\n",
                "s.yaml:3: bodies: 201881 nodes so far; at most 200000"},
        Refusal{"a line", mesh_scene("line.obj"), "s.yaml:4: bodies[0].cloth.mesh: "}));

TEST(SceneOverrides, ReplaceAnyKeyByItsPath) {
  const SceneSpec scene = load_scene_text(kCloth, "s.yaml",
                                          {{"bodies[0].cloth.cells", "[4, 5]"},
                                           {"step.integrator", "rk4"},
                                           {"gravity", "[0, 0, 0]"},
                                           {"bodies[0].cloth.material.thickness", "0.002"},
                                           {"colliders", "[{plane: {name: p}}]"}});
  EXPECT_EQ(scene.bodies[0].cells[0], 4);
  EXPECT_EQ(scene.bodies[0].cells[1], 5);
  EXPECT_EQ(scene.step.integrator, "rk4");
  EXPECT_EQ(scene.gravity.norm(), 0.0);
  EXPECT_EQ(scene.bodies[0].cloth_material.thickness, 0.002);
  ASSERT_EQ(scene.colliders.size(), 1u);
}

TEST(SceneOverrides, AreRefusedByTheirPath) {
  const std::vector<std::array<std::string, 3>> cases{
      {"bodies[1].cloth.cells", "[4, 5]", "--set bodies[1].cloth.cells: index 1 of a list of 1"},
      {"bodies[x]", "1", "--set bodies[x]: malformed path"},
      {"bodies[0", "1", "--set bodies[0: malformed path"},
      {"[0]", "1", "--set [0]: malformed path"},
      {"a..b", "1", "--set a..b: malformed path"},
      {"a.", "1", "--set a.: malformed path"},
      {"bodies[0]cloth", "1", "--set bodies[0]cloth: malformed path"},
      {"bodies.cloth", "1", "--set bodies.cloth: 'cloth' is looked for in something that is no map"},
      {"step[0]", "1", "--set step[0]: [...] after something that is no list"},
      {"step.dt", "[1", "--set step.dt: '[1': VALUE:1: not valid YAML"},
      {"step.dt", "-1", "--set step.dt: -1 is out of range; allowed: 1e-09 ... 2"},
      {"step.dt", "", "--set step.dt: must be a number, not nothing"},
      {"step.dtt", "1", "--set step.dtt: unknown key; did you mean 'dt'? Allowed: solver, accuracy"},
      {"step", "{dt: fast}", "--set step: step.dt: must be a number, not 'fast'"}};
  for (const auto& [path, value, expected] : cases) {
    const std::string message = refusal_of(kCloth, {{path, value}});
    EXPECT_EQ(message.rfind(expected, 0), 0u) << "expected: " << expected << "\ngot:      " << message;
  }
}

TEST(SceneFiles, ThatDoNotExistAreRefusedWithTheScenesThatDo) {
  const std::string dir = std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/config/scenes";
  try {
    find_scene("towel_on_tabel", dir);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.code(), Code::kNotFound);
    EXPECT_NE(std::string(error.what()).find("towel_on_table"), std::string::npos) << error.what();
  }
  EXPECT_THROW(find_scene("./nowhere.yaml", dir), InputError);
  EXPECT_THROW(find_scene("", dir), InputError);
  EXPECT_THROW(load_scene_file(dir), InputError);
  EXPECT_EQ(find_scene("minimal", dir), dir + "/minimal.yaml");
}

}  // namespace
}  // namespace deformable_sim
