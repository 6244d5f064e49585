// Scenes that change: bodies that come and go, materials and values; and worlds that go on in them.
#include "deformable_sim/scene/edit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"

namespace deformable_sim {
namespace {

SceneSpec scene_of(const std::string& yaml) {
  return load_scene_text(yaml, "s.yaml");
}

std::string refusal_of(const std::function<void()>& change) {
  try {
    change();
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

std::vector<std::string> names_of(const SceneSpec& scene) {
  std::vector<std::string> names;
  for (const BodySpec& body : scene.bodies) names.push_back(body.name);
  return names;
}

const char* kTwo = R"(bodies:
  - cloth: {name: towel, pins: [corner_0], material: {damping: 0.003}}
  - rope: {name: line, pose: {position: [0, 1, 0]}}
colliders:
  - box: {name: table, size: [1, 1, 0.1], pose: {position: [0, 0, -1]}, lets_through: [towel, line]}
grasps:
  - {name: hand, body: towel, select: {feature: corner_1}}
  - {name: other, body: line, select: {feature: end_0}}
script:
  - {at: 0.1, move_grasp: hand, pose: {position: [0, 0, 1]}}
  - {at: 0.2, grasp: {name: third, body: towel, select: {feature: corner_2}}}
  - {at: 0.3, release: pin_towel_corner_0}
  - {at: 0.4, release: third}
  - {at: 0.5, release: other}
)";

TEST(Edits, AddBodiesWithTheirGraspsAndNothingElse) {
  const SceneSpec added = load_scene_text(
      "gravity: [0, 0, -1]\nbodies:\n  - soft: {name: ball, box: {size: [0.1, 0.1, 0.1]}, pins: [corner_0]}\n",
      "more.yaml");
  Pose pose = Pose::Identity();
  pose.translate(Vec3(1, 2, 3.25));
  pose.rotate(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
  const SceneSpec both = with_bodies(scene_of(kTwo), added, pose);
  EXPECT_EQ(names_of(both), (std::vector<std::string>{"towel", "line", "ball"}));
  EXPECT_LT((both.bodies[2].pose.pose().matrix() - pose.matrix()).norm(), 1e-12);
  EXPECT_EQ(both.bodies[2].where.file, "more.yaml");
  EXPECT_EQ(both.bodies[2].where.line, 3);
  EXPECT_EQ(both.gravity.z(), -9.81);
  EXPECT_EQ(grasps_of(both).size(), 4u);
}

TEST(Edits, RefuseNamesThatAreTaken) {
  const SceneSpec again = load_scene_text("bodies:\n  - rope: {name: line}\n", "more.yaml");
  EXPECT_EQ(refusal_of([&] { with_bodies(scene_of(kTwo), again, {}); }).rfind("more.yaml:2: ", 0), 0u);
  const SceneSpec two = load_scene_text("bodies:\n  - rope: {name: a}\n  - rope: {name: b}\n", "more.yaml");
  EXPECT_EQ(refusal_of([&] { with_bodies(scene_of(kTwo), two, Pose::Identity()); }),
            "pose: is that of one body; there are 2");
}

TEST(Edits, TakeOutWhatNamesABodyThatGoes) {
  const SceneSpec one = without_body(scene_of(kTwo), "towel");
  EXPECT_EQ(names_of(one), std::vector<std::string>{"line"});
  ASSERT_EQ(one.grasps.size(), 1u);
  EXPECT_EQ(one.grasps[0].request.name, "other");
  ASSERT_EQ(one.script.size(), 1u);
  EXPECT_EQ(one.script[0].time, 0.5);
  EXPECT_EQ(one.colliders[0].collider.lets_through, std::vector<std::string>{"line"});
  EXPECT_NE(refusal_of([&] { without_body(one, "line"); }).find("is the only body"), std::string::npos);
  EXPECT_EQ(refusal_of([&] { without_body(one, "towel"); }), "no body named 'towel'; there are: line");
}

TEST(Edits, ChangeTheGivenKeysOfAMaterial) {
  const SceneSpec damped = with_material(scene_of(kTwo), "towel", "{thickness: 0.001}");
  EXPECT_EQ(damped.bodies[0].cloth_material.thickness, 0.001);
  EXPECT_EQ(damped.bodies[0].cloth_material.damping, 0.003);
  const SceneSpec denim = with_material(damped, "towel", "denim_11oz_black");
  EXPECT_EQ(denim.bodies[0].cloth_material.name, "denim_11oz_black");
  const SceneSpec light = with_material(denim, "towel", "areal_density: 0.2");
  EXPECT_EQ(light.bodies[0].cloth_material.name, "denim_11oz_black");
  EXPECT_EQ(light.bodies[0].cloth_material.areal_density, 0.2);
  EXPECT_EQ(with_material(scene_of(kTwo), "line", "{diameter: 0.02}").bodies[1].rope_material.diameter, 0.02);
}

TEST(Edits, RefuseMaterialsAsSceneFilesDo) {
  const SceneSpec scene = scene_of(kTwo);
  EXPECT_EQ(refusal_of([&] { with_material(scene, "towel", "{damping: -1}"); }),
            "material:1: bodies[0].cloth.material.damping: -1 is out of range; allowed: 0 ... 1");
  EXPECT_NE(refusal_of([&] { with_material(scene, "towel", "{dampening: 1}"); }).find("damping"), std::string::npos);
  EXPECT_NE(refusal_of([&] { with_material(scene, "towel", "[1]"); }).find("neither a name nor keys"),
            std::string::npos);
  EXPECT_NE(refusal_of([&] { with_material(scene, "towel", "{a: [}"); }).find("material:1: not valid"),
            std::string::npos);
  EXPECT_NE(refusal_of([&] { with_material(scene, "shirt", "{}"); }).find("towel, line"), std::string::npos);
}

TEST(Edits, WriteTextThatReadsAsTheSameScene) {
  for (const std::string& name : scene_names(default_scene_dir())) {
    const SceneSpec scene = load_scene_file(find_scene(name, default_scene_dir()), {{"title", "'5'"}});
    const std::string text = scene_text(scene);
    const SceneSpec again = load_scene_text(text, scene.file);
    EXPECT_EQ(scene_text(again), text) << name;
    EXPECT_EQ(again.title, "5");
    ASSERT_EQ(again.bodies.size(), scene.bodies.size()) << name;
    for (size_t b = 0; b < scene.bodies.size(); ++b) EXPECT_EQ(again.bodies[b].name, scene.bodies[b].name);
    // World::restore() refuses what another scene has saved.
    if (build_model(scene)->point_count() < 1000 && scene.forces.empty())
      EXPECT_NO_THROW(build_world(again)->restore(build_world(scene)->save())) << name;
  }
}

TEST(Edits, SetValuesAndCheckThem) {
  EXPECT_EQ(with_values(scene_of(kTwo), {{"gravity", "[0, 0, -1.6]"}}).gravity.z(), -1.6);
  EXPECT_EQ(refusal_of([&] {
              with_values(scene_of(kTwo), {{"air.damping", ".nan"}});
            }).rfind("--set air.damping: ", 0),
            0u);
}

/// Explicit steps remember nothing between them: a world that is continued at once goes on to the same bits.
const char* kMoving = R"(step: {integrator: symplectic_euler, dt: 0.0001}
bodies:
  - cloth: {name: towel, size: [0.2, 0.2], cells: [6, 6], pose: {position: [0, 0, 0.3]}}
  - rope: {name: cord, model: rod, length: 0.3, segments: 8, pose: {position: [0, 2, 0.3]}, material: {damping: 0}}
  - rope: {name: cable, model: rod, length: 0.3, segments: 8, pose: {position: [0, 1, 0.3]}, initial_twist: 3,
           material: {damping: 0}}
colliders:
  - sphere: {name: ball, radius: 0.1}
grasps:
  - {name: hand, body: towel, select: {feature: corner_0}}
  - {name: soft_hand, body: towel, select: {feature: corner_1}, stiffness: 50}
  - {name: plug, body: cable, select: {feature: end_0}}
)";

void move(World* world) {
  Pose up = Pose::Identity();
  up.translate(Vec3(-0.1, -0.1, 0.5));
  up.rotate(Eigen::AngleAxisd(1.0, Vec3::UnitX()));
  for (const std::string name : {"hand", "soft_hand"})
    ASSERT_TRUE(world->apply(command::MoveGrasp{name, up, 0.2}).status.ok());
  Pose turned = Pose::Identity();
  turned.translate(Vec3(-0.15, 1, 0.3));
  turned.rotate(Eigen::AngleAxisd(1.0, Vec3::UnitX()));
  ASSERT_TRUE(world->apply(command::MoveGrasp{"plug", turned, 0.2}).status.ok());
  Pose away = Pose::Identity();
  away.translate(Vec3(0.3, 0, 0));
  ASSERT_TRUE(world->apply(command::MoveCollider{"ball", away, 0.3}).status.ok());
}

void go(World* world, int steps) {
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(world->step().ok);
}

TEST(ContinuedWorlds, GoOnToTheSameBits) {
  const SceneSpec scene = scene_of(kMoving);
  const auto one = build_world(scene), other = build_world(scene, 1, nullptr, 0.0001);
  move(one.get());
  go(one.get(), 500);
  other->continue_from(*one);
  go(one.get(), 1000);
  go(other.get(), 1000);
  EXPECT_EQ(one->time(), other->time());
  EXPECT_EQ((one->state().x - other->state().x).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((one->state().v - other->state().v).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_GT((one->state().x - one->model().initial.x).cwiseAbs().maxCoeff(), 0.05) << "nothing has moved";
}

TEST(ContinuedWorlds, KeepABodyWhoseNodesHaveOtherPlaces) {
  // Steps that explicit Euler makes whole, with both bodies and with one.
  const SceneSpec scene = with_values(scene_of(kMoving), {{"step.dt", "0.00001"}});
  const auto one = build_world(scene),
             other = build_world(without_body(without_body(scene, "towel"), "cord"), 1, nullptr, 0.00001);
  move(one.get());
  go(one.get(), 3000);
  other->continue_from(*one);
  go(one.get(), 3000);
  go(other.get(), 3000);
  const Body &there = one->model().bodies[2], &here = other->model().bodies[0];
  ASSERT_NE(there.first_node, here.first_node);
  EXPECT_LT((one->state().x.middleCols(there.first_node, there.node_count) -
             other->state().x.middleCols(here.first_node, here.node_count))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  EXPECT_LT((one->state().x.rightCols(8) - other->state().x.rightCols(8)).cwiseAbs().maxCoeff(), 1e-12) << "angles";
  ASSERT_EQ(other->grasp_reports().size(), 1u);
  EXPECT_EQ(other->grasp_reports()[0].name, "plug");
}

TEST(ContinuedWorlds, KeepTheAngleOfARodThatBecomesThicker) {
  const SceneSpec scene = scene_of(kMoving);
  const auto one = build_world(scene);
  go(one.get(), 500);
  const auto other = build_world(with_material(scene, "cable", "{diameter: 0.012}"), 1, nullptr, 0.0001);
  other->continue_from(*one);
  const auto angle = [](const World& world) {
    return world.state().x(0, world.model().node_count() - 1) / world.model().bodies[2].radius_of_gyration;
  };
  EXPECT_NE(one->model().bodies[2].radius_of_gyration, other->model().bodies[2].radius_of_gyration);
  EXPECT_NEAR(angle(*one), angle(*other), 1e-12);
}

/// The same bodies go on to the bits of a world that was saved, friction and schemes of several steps among them.
TEST(ContinuedWorlds, OfEveryShippedSceneGoOnToTheSameBits) {
  int compared = 0;
  for (const std::string& name : scene_names(default_scene_dir())) {
    const SceneSpec scene = load_scene_file(find_scene(name, default_scene_dir()));
    const auto one = build_world(scene);
    go(one.get(), 20);
    one->save();
    const auto other = build_world(with_values(scene, {}), 1, nullptr, one->settings().dt);
    // With its step given, another solver may be the cheapest of those that are accurate enough.
    const WorldSettings &a = one->settings(), &b = other->settings();
    if (a.integrator != b.integrator || a.parts != b.parts || a.solver.linear != b.solver.linear) continue;
    ++compared;
    other->continue_from(*one);
    go(one.get(), 5);
    go(other.get(), 5);
    EXPECT_EQ((one->state().x - other->state().x).cwiseAbs().maxCoeff(), 0.0) << name;
    EXPECT_EQ((one->state().v - other->state().v).cwiseAbs().maxCoeff(), 0.0) << name;
  }
  EXPECT_GT(compared, 20);
}

/// A hanging rope is longer by lambda g L^2 / (2 E A).
TEST(ContinuedWorlds, HangAsTheirNewMaterialSays) {
  const double density = 0.1, length = 1.0, stiffness = 100.0;
  const SceneSpec soft = scene_of(
      "step: {dt: 0.01, integrator: implicit_euler, newton_iterations: 10}\n"
      "bodies:\n  - rope: {name: line, model: untwisted, length: 1, segments: 40, pins: [end_0], pose: {rpy: [0, "
      "1.5707963267948966, 0]},\n"
      "           material: {linear_density: 0.1, axial_stiffness: 100, bending_rigidity: 1.0e-6, damping: 0.1}}\n"
      "air: {damping: 5}\n");
  const auto extension = [](World* world) {
    go(world, 600);
    const Body& body = world->model().bodies[0];
    return (world->state().x.col(body.node_count - 1) - world->state().x.col(0)).norm() - 1.0;
  };
  auto world = build_world(soft);
  const double expected = density * 9.81 * length * length / (2.0 * stiffness);
  EXPECT_NEAR(extension(world.get()), expected, 0.01 * expected);
  auto stiff = build_world(with_material(soft, "line", "{axial_stiffness: 200}"), 1, nullptr, 0.01);
  stiff->continue_from(*world);
  EXPECT_EQ(stiff->time(), world->time());
  EXPECT_NEAR(extension(stiff.get()), 0.5 * expected, 0.01 * expected);
}

const char* kLying = R"(step: {dt: 0.01}
bodies:
  - cloth: {name: first, size: [0.2, 0.2], cells: [4, 4], touches: all}
)";
const char* kThrough = R"(bodies:
  - cloth: {name: second, size: [0.2, 0.2], cells: [4, 4], touches: all, pose: {rpy: [1.5707963, 0, 0.3], position: [0.01, 0.013, 0]}}
)";

TEST(ContinuedWorlds, RefuseABodyThatCrossesAnotherOne) {
  const SceneSpec scene = scene_of(kLying), both = with_bodies(scene, scene_of(kThrough), {});
  const auto one = build_world(scene), other = build_world(both, 1, nullptr, 0.01);
  EXPECT_NE(refusal_of([&] { other->continue_from(*one); }).find("'second'"), std::string::npos);
  EXPECT_NE(refusal_of([&] { build_world(both); }).find("'second'"), std::string::npos);
}

TEST(ContinuedWorlds, RefuseToBeResetWhereBodiesWouldCross) {
  const SceneSpec scene = scene_of(kLying), both = with_bodies(scene, scene_of(kThrough), {});
  const auto one = build_world(scene), other = build_world(both, 1, nullptr, 0.01);
  go(one.get(), 50);  // it falls 1.2 m
  other->continue_from(*one);
  go(other.get(), 5);
  const Nodes x = other->state().x;
  const Reply reply = other->apply(command::Reset{});
  EXPECT_EQ(reply.status.code, Code::kUnavailable);
  EXPECT_NE(reply.status.message.find("where they start"), std::string::npos);
  EXPECT_EQ((other->state().x - x).cwiseAbs().maxCoeff(), 0.0);
}

TEST(ContinuedWorlds, RefuseGraspsWhoseNamesAreInUse) {
  const SceneSpec scene = scene_of(kLying);
  const SceneSpec added = scene_of(
      "bodies:\n  - rope: {name: line, pose: {position: [0, 1, 0]}}\n"
      "grasps:\n  - {name: hand, body: line, select: {feature: end_0}}\n");
  const auto one = build_world(scene), other = build_world(with_bodies(scene, added, {}), 1, nullptr, 0.01);
  GraspRequest hand;
  hand.name = "hand";
  hand.body = "first";
  hand.selection.method = SelectionMethod::kFeature;
  hand.selection.feature = "corner_0";
  ASSERT_TRUE(one->apply(command::Grasp{hand}).status.ok());
  EXPECT_NE(refusal_of([&] { other->continue_from(*one); }).find("'hand'"), std::string::npos);
}

}  // namespace
}  // namespace deformable_sim
