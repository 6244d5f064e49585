// Signs, invariances and hand-computed values of the force terms.
#include <gtest/gtest.h>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

Nodes two_points(double distance) {
  return (Nodes(3, 2) << 0, distance, 0, 0, 0, 0).finished();
}

TEST(Spring, StretchedEndsAttractAndCompressedEndsRepel) {
  // f on i = k (|d| - L) d / |d| towards j.
  System body(two_points(1.1), Eigen::Vector2d(1, 1));
  body.add(make_springs("spring", {{0, 1, 1.0, 50.0, 0.0}}, 0));
  EXPECT_NEAR(body.forces()(0, 0), 5.0, 1e-12);
  EXPECT_NEAR(body.forces()(0, 1), -5.0, 1e-12);
  EXPECT_NEAR(body.potential_energy(), 0.25, 1e-14);
  body.state.x = two_points(0.9);
  EXPECT_NEAR(body.forces()(0, 0), -5.0, 1e-12);
}

TEST(Spring, DampingOpposesTheRateOfElongation) {
  // f on i = c (n . (v_j - v_i)) n.
  System body(two_points(1.0), Eigen::Vector2d(1, 1));
  body.add(make_springs("spring", {{0, 1, 1.0, 50.0, 3.0}}, 0));
  body.state.v.col(1) = Vec3(2, 5, 0);
  EXPECT_LT((body.forces().col(1) - Vec3(-6, 0, 0)).norm(), 1e-12);
  EXPECT_LT((body.forces().col(0) - Vec3(6, 0, 0)).norm(), 1e-12);
}

TEST(Spring, TakesNodesFromTheFirstNodeOfItsBody) {
  System body((Nodes(3, 3) << 9, 0, 2, 9, 0, 0, 9, 0, 0).finished(), Eigen::Vector3d(1, 1, 1));
  body.add(make_springs("spring", {{0, 1, 1.0, 50.0, 0.0}}, 1));
  EXPECT_EQ(body.forces().col(0).norm(), 0.0);
  EXPECT_NEAR(body.forces()(0, 1), 50.0, 1e-12);
}

TEST(Springs, FeelNoRigidMotion) {
  // Any rotation and translation of the rest shape has no force; v = w x r has no viscous force.
  const TriangleMesh mesh = make_grid(1, 1, 3, 3);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  stiffness.damping_time = 0.1;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add_springs(sheet_network(mesh, stiffness));
  const Mat3 rotation = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  body.state.x = (rotation * mesh.rest).colwise() + Vec3(3, -1, 2);
  const Vec3 spin(0.3, -2.0, 1.0);
  for (Eigen::Index i = 0; i < body.state.x.cols(); ++i) {
    body.state.v.col(i) = spin.cross(Vec3(body.state.x.col(i))) + Vec3(1, 1, 0);
  }
  EXPECT_LT(body.forces().cwiseAbs().maxCoeff(), 2e-12);  // k times the rounding of lengths
  System at_rest(mesh.rest, sheet_masses(mesh, 0.2));
  SheetStiffness dashpots = stiffness;
  dashpots.membrane = 1e-3;
  at_rest.add_springs(sheet_network(mesh, dashpots));
  at_rest.state.v = body.state.v;
  for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) at_rest.state.v.col(i) = spin.cross(Vec3(mesh.rest.col(i)));
  EXPECT_LT(at_rest.forces().cwiseAbs().maxCoeff(), 1e-14);
}

TEST(Spring, OfNoLengthHasNoForce) {
  System body(two_points(0.0), Eigen::Vector2d(1, 1));
  body.add(make_springs("spring", {{0, 1, 1.0, 50.0, 1.0}}, 0));
  EXPECT_EQ(body.forces().norm(), 0.0);
}

TEST(Gravity, WeighsTheMassesAndStoresMinusMgx) {
  System body(two_points(2.0), Eigen::Vector2d(1, 3));
  body.add(make_gravity(body.mass, Vec3(0.5, 0, -9.81)));
  EXPECT_LT((body.forces().rowwise().sum() - 4.0 * Vec3(0.5, 0, -9.81)).norm(), 1e-14);
  EXPECT_NEAR(body.potential_energy(), -3.0 * 0.5 * 2.0, 1e-14);
}

TEST(MassDamping, SlowsEachMassByItsOwnMomentum) {
  System body(two_points(2.0), Eigen::Vector2d(1, 3));
  body.add(make_mass_damping(body.mass, 0.2));
  body.state.v.col(1) = Vec3(1, -2, 0);
  EXPECT_LT((body.forces().col(1) - Vec3(-0.6, 1.2, 0)).norm(), 1e-15);
}

TEST(SheetDrag, IsTheDragOfAPlateAndPushesWithTheWind) {
  // 1/2 rho C_d A |u|^2, A = 1/2 m^2, u = 3 m/s from below.
  System body((Nodes(3, 3) << 0, 1, 0, 0, 0, 1, 0, 0, 0).finished(), Eigen::Vector3d(1, 1, 1));
  Air air;
  air.wind = Vec3(7, 0, 3);  // what blows along the face does not push
  body.add(make_sheet_drag({{0, 1, 2}}, air));
  EXPECT_LT((body.forces().rowwise().sum() - Vec3(0, 0, 0.5 * 1.2 * 1.0 * 0.5 * 9.0)).norm(), 1e-14);
  body.state.v.row(2).setConstant(3.0);
  EXPECT_LT(body.forces().norm(), 1e-15);
}

TEST(SheetDrag, DoesNotDependOnTheWinding) {
  System body((Nodes(3, 3) << 0, 1, 0, 0, 0, 1, 0, 0, 0.3).finished(), Eigen::Vector3d(1, 1, 1));
  Air air;
  air.wind = Vec3(1, 2, 3);
  body.add(make_sheet_drag({{0, 1, 2}}, air));
  System turned(body.state.x, body.mass);
  turned.add(make_sheet_drag({{0, 2, 1}}, air));
  EXPECT_LT((body.forces() - turned.forces()).norm(), 1e-15);
}

TEST(LineDrag, IsTheDragOfACylinderAcrossTheFlow) {
  // 1/2 rho C_d D l |u_n| u_n with D = 0.02 m, l = 2 m, u_n = -4 m/s.
  System body(two_points(2.0), Eigen::Vector2d(1, 1));
  Air air;
  air.wind = Vec3(5, -4, 0);
  body.add(make_line_drag({{0, 1}}, 0.02, air));
  EXPECT_LT((body.forces().rowwise().sum() - Vec3(0, -0.5 * 1.2 * 0.02 * 2.0 * 16.0, 0)).norm(), 1e-14);
}

TEST(Air, GustsAboutItsMeanWind) {
  Air air;
  air.wind = Vec3(4, 0, 0);
  air.gust_amplitude = 0.25;
  air.gust_frequency = 2.0;
  EXPECT_NEAR(air.wind_at(0.0).x(), 4.0, 1e-15);
  EXPECT_NEAR(air.wind_at(0.125).x(), 5.0, 1e-12);
}

TEST(TargetSprings, PullTowardsTheirTargets) {
  System body(two_points(1.0), Eigen::Vector2d(1, 1));
  auto term = std::make_unique<TargetSprings>(std::vector<int>{1}, 20.0);
  term->set_targets(Vec3(1, 0, 0.5));
  body.add(std::move(term));
  EXPECT_LT((body.forces().col(1) - Vec3(0, 0, 10)).norm(), 1e-14);
  EXPECT_EQ(body.forces().col(0).norm(), 0.0);
  EXPECT_NEAR(body.potential_energy(), 0.5 * 20 * 0.25, 1e-14);
}

}  // namespace
}  // namespace deformable_sim::test
