// What a scene becomes: features, masses, poses, contact radii, grasps from pins.
#include "deformable_sim/scene/build.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

SceneSpec scene(const std::string& yaml) {
  return load_scene_text(yaml, "s.yaml");
}

TEST(GridFeatures, GoAroundTheSheet) {
  // Corners (0,0), (nx,0), (nx,ny), (0,ny); edge k from corner k to the next.
  const auto model = build_model(scene("bodies:\n  - cloth: {name: a, size: [3, 2], cells: [3, 2]}\n"));
  const Body& body = model->bodies[0];
  const auto at = [&](const std::string& feature) {
    return Vec3(model->initial.x.col(body.features.at(feature).at(0)));
  };
  EXPECT_LT((at("corner_0") - Vec3(-1.5, -1, 0)).norm(), 1e-12);
  EXPECT_LT((at("corner_1") - Vec3(1.5, -1, 0)).norm(), 1e-12);
  EXPECT_LT((at("corner_2") - Vec3(1.5, 1, 0)).norm(), 1e-12);
  EXPECT_LT((at("corner_3") - Vec3(-1.5, 1, 0)).norm(), 1e-12);
  for (int k = 0; k < 4; ++k) {
    const std::vector<int>& edge = body.features.at("edge_" + std::to_string(k));
    EXPECT_EQ(edge.front(), body.features.at("corner_" + std::to_string(k)).front());
    EXPECT_EQ(edge.back(), body.features.at("corner_" + std::to_string((k + 1) % 4)).front());
    EXPECT_EQ(edge.size(), k % 2 == 0 ? 4u : 3u);
  }
  EXPECT_LT(at("center").norm(), 0.51);
}

TEST(RopeFeatures, AreTheEndsAndTheMiddle) {
  const auto model =
      build_model(scene("bodies:\n  - rope: {name: a, length: 2, segments: 10}\n"
                        "  - rope: {name: b, length: 2, segments: 10, closed: true}\n"));
  const Body& line = model->bodies[0];
  EXPECT_LT((model->initial.x.col(line.features.at("end_0")[0]) - Vec3(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((model->initial.x.col(line.features.at("end_1")[0]) - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT(model->initial.x.col(line.features.at("center")[0]).norm(), 1e-12);
  const Body& loop = model->bodies[1];
  const Vec3 start = model->initial.x.col(loop.first_node + loop.features.at("end_0")[0]);
  const Vec3 opposite = model->initial.x.col(loop.first_node + loop.features.at("center")[0]);
  EXPECT_LT((start + opposite).norm(), 1e-12);
  EXPECT_EQ(loop.features.count("end_1"), 0u);
}

TEST(BuiltModel, WeighsWhatItsMaterialSays) {
  // m = areal density x area + linear density x length.
  const auto model =
      build_model(scene("bodies:\n"
                        "  - cloth: {name: a, size: [0.4, 0.5], material: {areal_density: 0.3}}\n"
                        "  - rope: {name: b, length: 2, material: {linear_density: 0.05}}\n"));
  EXPECT_NEAR(model->mass.sum(), 0.3 * 0.4 * 0.5 + 0.05 * 2, 1e-12);
  EXPECT_EQ(model->bodies[1].first_node, model->bodies[0].node_count);
}

/// Elastic energy (J) of a one-body scene stretched by `strain` along x.
double stretched_energy(const std::string& yaml, double strain) {
  const auto model = build_model(scene("gravity: [0, 0, 0]\n" + yaml));
  State s = model->initial;
  s.x.row(0) *= 1.0 + strain;
  double energy = 0.0;
  for (const auto& term : model->energies) energy += term->value(s);
  return energy;
}

TEST(BuiltRope, IsAsStiffAsItsModulusAndCrossSection) {
  // E = 1/2 (Y pi d^2 / 4) strain^2 length, exact for springs in a row.
  const double energy = stretched_energy(
      "bodies:\n  - rope: {name: a, length: 2, material: {youngs_modulus: 1e6, diameter: 0.01, bend_stiffness: 0}}\n",
      0.01);
  EXPECT_NEAR(energy, 0.5 * 1e6 * 0.25 * M_PI * 1e-4 * 1e-4 * 2, 1e-9);
}

TEST(BuiltCloth, IsAsStiffAsItsModulusAndThickness) {
  // E = 1/2 (Y h / (1 - nu^2)) strain^2 area with the sides held. 15 %: free edges, and Poisson's ratio as springs have
  // it.
  const auto cloth = [](const std::string& material) {
    return stretched_energy(
        "bodies:\n  - cloth: {name: a, size: [1, 0.5], cells: [40, 20], material: {" + material + "}}\n", 0.01);
  };
  const double energy = cloth("youngs_modulus: 1e6, thickness: 0.001, poissons_ratio: 0.3");
  EXPECT_NEAR(energy, 0.5 * 1000 / (1 - 0.09) * 1e-4 * 0.5, 0.15 * 0.025);
  EXPECT_NEAR(cloth("youngs_modulus: 2e6, thickness: 0.001, poissons_ratio: 0.3"), 2 * energy, 1e-9);
  EXPECT_NEAR(cloth("youngs_modulus: 1e6, thickness: 0.002, poissons_ratio: 0.3"), 2 * energy, 1e-9);
}

TEST(BuiltModel, StandsWhereItsPoseSays) {
  // rpy about fixed axes: yaw 90 degrees takes the rope's x axis to y; a quaternion says the same.
  for (const std::string& turn : {std::string("rpy: [0, 0, 1.5707963267948966]"),
                                  std::string("orientation: [0, 0, 0.7071067811865476, 0.7071067811865476]")}) {
    const auto model = build_model(
        scene("bodies:\n  - rope: {name: a, length: 2, segments: 2, pose: {position: [1, 2, 3], " + turn + "}}\n"));
    EXPECT_LT((model->initial.x.col(2) - Vec3(1, 3, 3)).norm(), 1e-9) << turn;
  }
}

TEST(PoseText, TurnsAboutFixedAxesXThenYThenZ) {
  // R = Rz(yaw) Ry(pitch) Rx(roll), REP 103.
  const SceneSpec s = scene("bodies:\n  - rope: {name: a, pose: {rpy: [0.3, -0.7, 1.1]}}\n");
  const Mat3 expected = (Eigen::AngleAxisd(1.1, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.7, Vec3::UnitY()) *
                         Eigen::AngleAxisd(0.3, Vec3::UnitX()))
                            .toRotationMatrix();
  EXPECT_LT((s.bodies[0].pose.pose().linear() - expected).norm(), 1e-12);
}

TEST(ContactRadius, IsHalfTheThicknessButNotBelowTheFloor) {
  const auto model =
      build_model(scene("bodies:\n"
                        "  - cloth: {name: thin, material: {thickness: 0.0003}}\n"
                        "  - cloth: {name: thick, material: {thickness: 0.01}}\n"
                        "  - rope: {name: rope, material: {diameter: 0.012}}\n"
                        "  - rope: {name: given, contact_radius: 0.02}\n"));
  EXPECT_EQ(model->bodies[0].contact_radius, kMinContactRadius);
  EXPECT_EQ(model->bodies[1].contact_radius, 0.005);
  EXPECT_EQ(model->bodies[2].contact_radius, 0.006);
  EXPECT_EQ(model->bodies[3].contact_radius, 0.02);
  EXPECT_FALSE(model->bodies[0].contact_at_faces);
  EXPECT_TRUE(model->bodies[2].contact_at_faces);
}

TEST(BuiltModel, HoldsNothingThatTheSceneLeavesOut) {
  const auto names = [](const Model& model) {
    std::vector<std::string> list;
    for (const auto& energy : model.energies) list.push_back(energy->name());
    return list;
  };
  const std::string body = "bodies:\n  - rope: {name: a, segments: 4, material: {bend_stiffness: 0}}\n";
  EXPECT_EQ(names(*build_model(scene("gravity: [0, 0, 0]\n" + body))).size(), 1u) << "stretch springs only";
  EXPECT_EQ(names(*build_model(scene(body))).size(), 2u) << "and gravity";
  EXPECT_EQ(names(*build_model(scene("air: {drag_coefficient: 1}\n" + body))).size(), 3u) << "and drag";
}

TEST(Pins, BecomeGraspsThatHoldStill) {
  const auto world = build_world(scene("bodies:\n  - cloth: {name: a, cells: [3, 2], pins: [corner_0, edge_1]}\n"));
  const Snapshot before = world->snapshot();
  ASSERT_EQ(before.grasps.size(), 2u);
  EXPECT_EQ(before.grasps[0].name, "pin_a_corner_0");
  EXPECT_EQ(before.grasps[1].name, "pin_a_edge_1");
  EXPECT_EQ(before.grasps[1].nodes.size(), 3u);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(world->step().ok);
  const Snapshot after = world->snapshot();
  for (const GraspReport& grasp : before.grasps) {
    for (const int node : grasp.nodes) EXPECT_LT((after.x.col(node) - before.x.col(node)).norm(), 1e-12);
  }
}

TEST(Grasps, AreFoundByEveryKindOfSelection) {
  const auto world = build_world(
      scene("bodies:\n  - cloth: {name: a, size: [1, 1], cells: [10, 10], pose: {position: [0, 0, 1]}}\n"
            "grasps:\n"
            "  - {name: near, body: a, select: {nearest: [0.49, 0.51, 1]}}\n"
            "  - {name: ball, body: a, select: {radius: 0.11, center: [0, 0, 1]}, pose: {position: [0, 0, 1.1]}}\n"
            "  - {name: strip, body: a, select: {box: [0.02, 2, 0.02], pose: {position: [-0.5, 0, 1]}}}\n"
            "  - {name: ids, body: a, select: {nodes: [5, 6]}, stiffness: 100}\n"));
  const Snapshot s = world->snapshot();
  ASSERT_EQ(s.grasps.size(), 4u);
  EXPECT_EQ(s.grasps[0].nodes, std::vector<int>{120});
  EXPECT_EQ(s.grasps[1].nodes.size(), 5u);
  EXPECT_LT((s.grasps[1].world_from_grasp.translation() - Vec3(0, 0, 1.1)).norm(), 1e-12);
  EXPECT_EQ(s.grasps[2].nodes.size(), 11u);
  EXPECT_EQ(s.grasps[3].nodes, (std::vector<int>{5, 6}));
}

TEST(MeshPaths, AreRelativeToTheSceneFileOrToThePackage) {
  const std::string source = DEFORMABLE_SIM_SOURCE_DIR;
  const auto resolved = [](const std::string& origin, const std::string& mesh) {
    return load_scene_text("bodies:\n  - cloth: {name: a, mesh: \"" + mesh + "\"}\n", origin).bodies[0].mesh;
  };
  EXPECT_EQ(resolved(source + "/config/scenes/x.yaml", "../../meshes/tshirt.obj"), source + "/meshes/tshirt.obj");
  EXPECT_EQ(resolved("/elsewhere/x.yaml", "package://deformable_sim/meshes/tshirt.obj"),
            package_dir() + "/meshes/tshirt.obj");
  EXPECT_EQ(resolved("/elsewhere/x.yaml", "/a/b.obj"), "/a/b.obj");
}

TEST(BuildWorld, MovesTheSmallestSheetsInSinglePrecisionAsInDouble) {
  // x_single - x_double -> 0: also where springs that do not exist start at the node in the middle, which lies where
  // nodes that do not exist are said to be.
  for (const char* cells : {"[1, 1]", "[2, 1]", "[2, 2]", "[3, 3]"}) {
    Nodes x[2];
    for (int single = 0; single < 2; ++single) {
      const auto world = build_world(scene(std::string("bodies:\n  - cloth: {name: a, pins: [corner_0], cells: ") +
                                           cells + "}\nstep: {dt: 0.01, integrator: substepped_verlet, precision: " +
                                           (single == 1 ? "single" : "double") + "}\n"));
      for (int k = 0; k < 20; ++k) ASSERT_TRUE(world->step().ok) << cells;
      x[single] = world->state().x;
    }
    EXPECT_LT((x[1] - x[0]).cwiseAbs().maxCoeff(), 1e-4) << cells;
  }
}

}  // namespace
}  // namespace deformable_sim
