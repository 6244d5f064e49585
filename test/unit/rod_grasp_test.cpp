// Grippers that hold the ends of rods with twist, and the rest of what a World does with them.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/grasp/selection.h"
#include "deformable_sim/core/rod_frames.h"
#include "support/rods.h"
#include "support/small_worlds.h"

namespace deformable_sim::test {
namespace {

constexpr int kSegments = 10;
constexpr double kSpacing = 0.05;  // m

RodSection cable() {
  RodSection s;
  s.stretch = 500.0;
  s.bend_1 = s.bend_2 = 0.01;
  s.twist = 0.008;
  s.damping = 0.01;
  s.radius_of_gyration = 0.004;
  s.linear_density = 0.1;
  return s;
}

std::shared_ptr<Model> cable_model(const Vec3& gravity, double damping = 0.01) {
  RodSection section = cable();
  section.damping = damping;
  return rod_model({line_along(Vec3::UnitX(), kSpacing, kSegments + 1)}, section, {}, gravity);
}

GraspRequest grasp_end(const std::string& feature, const Model& model) {
  GraspRequest request;
  request.name = feature;
  request.body = "rod_0";
  request.selection.method = SelectionMethod::kFeature;
  request.selection.feature = feature;
  request.has_frame = true;
  const int node = model.bodies[0].features.at(feature)[0];
  request.world_from_grasp.translation() = model.initial.x.col(node);
  return request;
}

std::unique_ptr<World> held_world(std::shared_ptr<const Model> model, const std::string& integrator = "implicit_euler",
                                  double dt = 0.01) {
  WorldSettings settings;
  settings.dt = dt;
  settings.integrator = integrator;
  settings.solver = exact_settings(1e-8);
  const std::vector<GraspRequest> grasps = {grasp_end("end_0", *model), grasp_end("end_1", *model)};
  return std::make_unique<World>(std::move(model), settings, std::vector<Collider>{}, grasps);
}

void run(World* world, int steps) {
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(world->step().ok);
}

TEST(RodGrasp, TurnsTheEndByMoreThanATurnAndFeelsTheMoment) {
  // M = C phi / L, L between the middles of the held segments; on both grippers, opposite.
  const auto world = held_world(cable_model(Vec3::Zero()));
  const double pull = 0.01, length = kSpacing * (kSegments - 1);
  Pose end = at(kSpacing * kSegments + pull, 0, 0);
  ASSERT_TRUE(world->apply(command::MoveGrasp{"end_1", end, 0.1}).status.ok());
  run(world.get(), 10);
  double turned = 0.0;
  for (int k = 1; k <= 12; ++k) {  // quarter turns: three turns
    end.linear() = Eigen::AngleAxisd(k * M_PI / 2, Vec3::UnitX()).toRotationMatrix();
    ASSERT_TRUE(world->apply(command::MoveGrasp{"end_1", end, 0.12}).status.ok());
    for (int i = 0; i < 12; ++i) {
      run(world.get(), 1);
      const double now = segment_angle(world->model(), world->model().bodies[0], world->state().x, kSegments - 1);
      EXPECT_LT(std::abs(now - turned), 0.2) << "the angle jumped";
      turned = now;
    }
  }
  EXPECT_NEAR(turned, 6.0 * M_PI, 1e-9);
  run(world.get(), 150);
  const double moment = cable().twist * turned / length;
  const auto grasps = world->snapshot().grasps;
  EXPECT_NEAR(grasps[1].torque.x(), -moment, 1e-6 * moment);
  EXPECT_NEAR(grasps[0].torque.x(), moment, 1e-6 * moment);
  const double tension = cable().stretch * pull / (kSpacing * (kSegments - 2));  // the held segments keep their length
  EXPECT_NEAR(grasps[1].force.x(), -tension, 1e-6 * tension);
}

TEST(RodGrasp, WrenchesBalanceOnABentAndTwistedRod) {
  // Sum of forces = 0 and sum of moments about any point = 0 at rest without gravity.
  const auto world = held_world(cable_model(Vec3::Zero()));
  Pose end = at(0.35, 0.1, 0.05, 1.9, Vec3(1, 0.4, -0.3));
  ASSERT_TRUE(world->apply(command::MoveGrasp{"end_1", end, 1.0}).status.ok());
  run(world.get(), 400);
  const auto grasps = world->snapshot().grasps;
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (const GraspReport& g : grasps) {
    force += g.force;
    moment += g.torque + g.world_from_grasp.translation().cross(g.force);
  }
  EXPECT_GT(grasps[0].torque.norm(), 1e-3);
  EXPECT_LT(force.norm(), 1e-6 * grasps[0].force.norm());
  EXPECT_LT(moment.norm(), 1e-6 * grasps[0].torque.norm());
}

TEST(RodGrasp, ClampsTheDirectionOfTheEnd) {
  // The end, its neighbour and the material frame between them move as one with the gripper.
  const auto world = held_world(cable_model(Vec3(0, 0, -9.81)));
  EXPECT_EQ(world->snapshot().grasps[0].nodes, (std::vector<int>{0, 1}));
  const Body& body = world->model().bodies[0];
  const Mat3 before = material_frame(world->model(), body, world->state(), 0);
  const Pose pose = at(0.02, 0.01, 0.03, 0.8, Vec3(0.2, 1.0, 0.5));
  ASSERT_TRUE(world->apply(command::MoveGrasp{"end_0", pose, 0.4}).status.ok());
  run(world.get(), 60);
  EXPECT_LT((world->state().x.col(1) - pose * Vec3(kSpacing, 0, 0)).norm(), 1e-12);
  EXPECT_LT((material_frame(world->model(), body, world->state(), 0) - pose.linear() * before).norm(), 1e-9);
}

TEST(RodGrasp, HoldsPlacesOnlyWhenAsked) {
  const auto model = cable_model(Vec3(0, 0, -9.81));
  GraspRequest ball = grasp_end("end_0", *model);
  ball.points_only = true;
  World world(model, WorldSettings(), {}, {ball});
  EXPECT_EQ(world.snapshot().grasps[0].nodes, std::vector<int>{0});
  run(&world, 20);
  EXPECT_LT(world.state().x(2, 1), -1e-3);
}

TEST(RodGrasp, RefusesANeighbourThatAnotherGraspHolds) {
  const auto model = cable_model(Vec3::Zero());
  World world(model, WorldSettings(), {}, {grasp_nodes("middle", "rod_0", {1})});
  const Reply reply = world.apply(command::Grasp{grasp_end("end_0", *model)});
  EXPECT_EQ(reply.status.code, Code::kUnavailable);
}

TEST(RodGrasp, LeavesChainsOfSpringsAsTheyAre) {
  Nodes x = Nodes::Zero(3, 4);
  x.row(0) << 0, 1, 2, 3;
  const auto model = points_model(x, 1.0, Vec3::Zero());
  EXPECT_EQ(clamped_nodes(model->bodies[0], {0}), std::vector<int>{0});
}

TEST(RodWorld, RestoresAStateToTheLastBit) {
  const auto model = cable_model(Vec3(0, 0.3, -9.81));
  const auto world = held_world(model, "symplectic_euler", 0.001);
  ASSERT_TRUE(world->apply(command::MoveGrasp{"end_1", at(0.45, 0, 0, 2.0, Vec3::UnitX()), 0.2}).status.ok());
  run(world.get(), 250);
  const Body& body = model->bodies[0];
  const State saved = world->state();
  const command::SetBodyState set{"rod_0", saved.x.leftCols(body.node_count), saved.v.leftCols(body.node_count),
                                  rod_state(*model, body, saved)};
  run(world.get(), 50);
  const State expected = world->state();
  EXPECT_NE(expected.directors, saved.directors);
  ASSERT_TRUE(world->apply(set).status.ok());
  EXPECT_EQ(world->state().directors, saved.directors);
  EXPECT_EQ(world->state().tangents, saved.tangents);
  run(world.get(), 50);
  EXPECT_EQ(world->state().x, expected.x);
  EXPECT_EQ(world->state().v, expected.v);
  EXPECT_EQ(world->state().directors, expected.directors);
  EXPECT_EQ(world->state().reference_twists, expected.reference_twists);
}

TEST(RodWorld, KeepsTheFramesWhenAStateWithoutThemIsSetBack) {
  const auto model = cable_model(Vec3(0, 0.3, -9.81));
  const auto world = held_world(model);
  run(world.get(), 20);
  const State before = world->state();
  const int count = model->bodies[0].node_count;
  ASSERT_TRUE(
      world->apply(command::SetBodyState{"rod_0", before.x.leftCols(count), before.v.leftCols(count)}).status.ok());
  EXPECT_TRUE(same_state(world->state(), before));
  EXPECT_EQ(world->state().directors, before.directors);
  EXPECT_EQ(world->state().reference_twists, before.reference_twists);
}

TEST(RodWorld, RefusesBadFrames) {
  const auto model = cable_model(Vec3::Zero());
  World world(model, WorldSettings(), {}, {});
  const Nodes x = model->initial.x.leftCols(kSegments + 1), v = Nodes::Zero(3, kSegments + 1);
  const RodState good = rod_state(*model, model->bodies[0], model->initial);
  RodState tilted = good, huge = good;
  tilted.block<3, 1>(2, 4) = Vec3::UnitX();
  huge(0, 3) = std::nan("");
  for (const RodState& bad : {RodState(good.leftCols(3)), tilted, huge}) {
    const Reply reply = world.apply(command::SetBodyState{"rod_0", x, v, bad});
    EXPECT_EQ(reply.status.code, Code::kInvalidArgument);
    EXPECT_TRUE(same_state(world.state(), model->initial));
  }
  EXPECT_TRUE(world.apply(command::SetBodyState{"rod_0", x, v, good}).status.ok());
}

TEST(RodWorld, MovesEachOfTwoRodsLikeOneAlone) {
  const Vec3 gravity(0, 1.0, -9.81);
  Polyline line = line_along(Vec3::UnitX(), kSpacing, kSegments + 1), other = line;
  for (int i = 0; i <= kSegments; ++i) line.rest(2, i) = 0.01 * std::sin(0.4 * i);
  RodSection section = cable();
  section.bend_2 = 0.02;
  RodRest rest = curved(3.0, kSegments - 1, Vec3::UnitY());
  WorldSettings settings;
  settings.dt = 1e-4;
  settings.integrator = "symplectic_euler";
  World alone(rod_model({line}, section, rest, gravity), settings, {}, {});
  World both(rod_model({other, line}, section, rest, gravity), settings, {}, {});
  // Steps of explicit schemes may be split by the stiffer of the two: both worlds are below the limit.
  run(&alone, 200);
  run(&both, 200);
  const Body& second = both.model().bodies[1];
  EXPECT_EQ(both.state().x.middleCols(second.first_node, second.node_count), alone.state().x.leftCols(kSegments + 1));
  EXPECT_EQ(both.state().directors.rightCols(kSegments), alone.state().directors);
  const auto a = alone.snapshot().bodies[0], b = both.snapshot().bodies[1];
  EXPECT_DOUBLE_EQ(a.kinetic_energy, b.kinetic_energy);
  EXPECT_DOUBLE_EQ(a.elastic_energy, b.elastic_energy);
  EXPECT_GT(a.elastic_energy, 0.0);
}

TEST(RodWorld, CountsTheEnergyOfSpinAndNoWeightOfAngles) {
  const auto model = cable_model(Vec3(3, 0, -9.81), 0.0);
  World world(model, WorldSettings(), {}, {});
  RodState rod = rod_state(*model, model->bodies[0], model->initial);
  const double rate = 7.0;  // rad/s
  rod.row(1).setConstant(rate * cable().radius_of_gyration);
  const Nodes x = model->initial.x.leftCols(kSegments + 1), v = Nodes::Zero(3, kSegments + 1);
  const double weight = world.snapshot().bodies[0].potential_energy;
  ASSERT_TRUE(world.apply(command::SetBodyState{"rod_0", x, v, rod}).status.ok());
  // 1/2 i L omega^2, i = mu rho^2.
  const double inertia = cable().linear_density * kSpacing * kSegments * std::pow(cable().radius_of_gyration, 2);
  EXPECT_NEAR(world.snapshot().bodies[0].kinetic_energy, 0.5 * inertia * rate * rate, 1e-15);
  EXPECT_EQ(world.snapshot().bodies[0].potential_energy, weight);
  run(&world, 10);
  // Falling freely, a straight rod goes on spinning: z = -g t (t + dt) / 2 of backward Euler, no weight in the angles.
  const double t = 0.1;
  EXPECT_NEAR(world.state().x(2, 3), -0.5 * 9.81 * t * (t + 0.01), 1e-9);
  EXPECT_NEAR(segment_angle(*model, model->bodies[0], world.state().x, 5), rate * t, 1e-9);
}

}  // namespace
}  // namespace deformable_sim::test
