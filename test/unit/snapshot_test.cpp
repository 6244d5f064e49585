// What a snapshot and its derived quantities say.
#include <gtest/gtest.h>

#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

TEST(Snapshot, IsACopyThatLaterStepsDoNotTouch) {
  test::Sheet sheet;
  sheet.cells_x = sheet.cells_y = 4;
  World world(test::sheet_model(sheet), WorldSettings(), {}, {});
  const Snapshot before = world.snapshot();
  world.step();
  EXPECT_EQ(before.x, world.model().initial.x);
  EXPECT_EQ(before.time, 0.0);
  EXPECT_NE(world.snapshot().x, before.x);
  EXPECT_EQ(before.model.get(), &world.model());
}

TEST(Snapshot, BalancesTheEnergyOfABody) {
  // Free fall without drag: E_kin = m (g t)^2 / 2, E_pot = -m g dz, no elastic energy, no strain.
  test::Sheet sheet;
  sheet.cells_x = sheet.cells_y = 4;
  WorldSettings settings;
  settings.integrator = "symplectic_euler";
  World world(test::sheet_model(sheet), settings, {}, {});
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(world.step().ok);
  const Snapshot s = world.snapshot();
  const double mass = world.model().mass.sum(), t = world.time();
  EXPECT_NEAR(s.bodies[0].kinetic_energy, 0.5 * mass * 9.81 * 9.81 * t * t, 1e-9);
  EXPECT_NEAR(s.bodies[0].potential_energy, mass * 9.81 * s.x.row(2).mean(), 1e-9);
  EXPECT_NEAR(s.bodies[0].elastic_energy, 0.0, 1e-12);
  EXPECT_NEAR(s.bodies[0].max_strain, 0.0, 1e-12);
}

TEST(Snapshot, OfTheMotionAloneLeavesEnergiesAndStrainsOut) {
  // The same nodes; energies of a stretched, moving sheet only where they were asked for.
  test::Sheet sheet;
  sheet.cells_x = sheet.cells_y = 4;
  World world(test::sheet_model(sheet), WorldSettings(), {}, {});
  const Nodes x = 1.1 * world.state().x;
  ASSERT_TRUE(world.apply(command::SetBodyState{world.model().bodies[0].name, x, x}).status.ok());
  const Snapshot whole = world.snapshot(), motion = world.snapshot(SnapshotDetail::kMotion);
  EXPECT_EQ(motion.x, whole.x);
  EXPECT_EQ(motion.v, whole.v);
  ASSERT_EQ(motion.bodies.size(), whole.bodies.size());
  EXPECT_GT(whole.bodies[0].elastic_energy, 0.0);
  EXPECT_NEAR(whole.bodies[0].max_strain, 0.1, 1e-12);
  EXPECT_EQ(motion.bodies[0].elastic_energy, 0.0);
  EXPECT_EQ(motion.bodies[0].kinetic_energy, 0.0);
  EXPECT_EQ(motion.bodies[0].max_strain, 0.0);
}

TEST(Snapshot, CountsElasticEnergyWithTheBodyItBelongsTo) {
  // Two springs, k (l - L)^2 / 2 each, of two bodies: 1000 N/m by 10 mm and 20 mm.
  Nodes x = Nodes::Zero(3, 4);
  x.row(0) << 0.0, 0.11, 1.0, 1.12;
  auto model = test::points_model(x, 0.1, Vec3(0, 0, -9.81));
  model->bodies[0].node_count = 2;
  Body second = model->bodies[0];
  second.name = "second";
  second.first_node = 2;
  model->bodies.push_back(second);
  SpringLink link;
  link.b = 1;
  link.rest_length = 0.1;
  link.stiffness = 1000.0;
  model->energies.push_back(make_springs("stretch springs", {link}, 0));
  model->energies.push_back(make_springs("stretch springs", {link}, 2));
  const Snapshot s = World(model, WorldSettings(), {}, {}).snapshot();
  EXPECT_NEAR(s.bodies[0].elastic_energy, 0.05, 1e-12);
  EXPECT_NEAR(s.bodies[1].elastic_energy, 0.2, 1e-12);
}

TEST(Snapshot, CountsKineticEnergyByTheMassMatrixItMovesWith) {
  // v^T M v / 2 of a bar with M = m/6 [2 1; 1 2]: ends at 1 m/s, m/2 together, m/6 apart (m/2 if lumped); m = 0.2 kg.
  Nodes x = Nodes::Zero(3, 4);
  x.row(0) << 0.0, 0.1, 1.0, 1.1;
  auto model = test::points_model(x, 0.1, Vec3::Zero());
  model->bodies[0].node_count = 2;
  Body second = model->bodies[0];
  second.name = "second";
  second.first_node = 2;
  model->bodies.push_back(second);
  model->initial.v.row(1) << 1.0, 1.0, 1.0, -1.0;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 4; ++i) {
    entries.emplace_back(i, i, 0.2 / 3.0);
    entries.emplace_back(i, i ^ 1, 0.2 / 6.0);
  }
  model->mass_matrix.resize(4, 4);
  model->mass_matrix.setFromTriplets(entries.begin(), entries.end());
  const Snapshot s = World(model, WorldSettings(), {}, {}).snapshot();
  EXPECT_NEAR(s.bodies[0].kinetic_energy, 0.1, 1e-15);
  EXPECT_NEAR(s.bodies[1].kinetic_energy, 0.2 / 6.0, 1e-15);
}

TEST(NodeStrain, IsTheLargestOfTheEdgesAtTheNode) {
  // l / L - 1 along a chain of two edges stretched by +10 % and -20 %.
  Nodes x = Nodes::Zero(3, 4);
  x.row(0) << 9.0, 0.0, 0.11, 0.19;
  Body body;
  body.first_node = 1;
  body.node_count = 3;
  body.strain_edges = {{{{1, 2}}, 0.1}, {{{2, 3}}, 0.1}};
  const Eigen::VectorXf strain = node_strain(body, x);
  EXPECT_NEAR(strain[0], 0.1, 1e-6);
  EXPECT_NEAR(strain[1], -0.2, 1e-6);
  EXPECT_NEAR(strain[2], -0.2, 1e-6);
}

TEST(NodeNormals, PointOutOfTheSheetAndFollowIt) {
  test::Sheet sheet;
  const auto model = test::sheet_model(sheet);
  const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3Xf flat = node_normals(model->bodies[0], model->initial.x);
  const Eigen::Matrix3Xf turned = node_normals(model->bodies[0], turn * model->initial.x);
  for (Eigen::Index i = 0; i < flat.cols(); ++i) {
    EXPECT_NEAR((flat.col(i) - Eigen::Vector3f::UnitZ()).norm(), 0.0f, 1e-6f);
    EXPECT_NEAR((turned.col(i) - (turn * Vec3::UnitZ()).cast<float>()).norm(), 0.0f, 1e-6f);
  }
}

TEST(NodeNormals, AreUnitEvenWhereFacesVanish) {
  test::Sheet sheet;
  const auto model = test::sheet_model(sheet);
  const Eigen::Matrix3Xf normals = node_normals(model->bodies[0], Nodes::Zero(3, model->node_count()));
  EXPECT_TRUE(((normals.colwise().norm().array() - 1.0f).abs() < 1e-6f).all());
}

}  // namespace
}  // namespace deformable_sim
