// Strain limits: the tension within a step, the factor, the projection after it, and both in a world.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/strain_limit.h"
#include "support/derivative_harness.h"
#include "support/small_worlds.h"

namespace deformable_sim::test {
namespace {

Nodes random_nodes(Eigen::Index n, double scale, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, scale);
  return Nodes::NullaryExpr(3, n, [&] { return normal(generator); });
}

TEST(LimitSprings, HaveTheDerivativesTheyDeliver) {
  // E = t^2 / (2 k), t = max(0, T + k (r - l)): taut beyond l, taut below it by the tension they start with, slack.
  for (const double scale : {0.3, 1.0, 2.0}) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      LimitSprings term({{0, 1, 0.5, 60.0, 0.0},
                         {1, 2, 2.0, 20.0, 15.0},
                         {3, 0, 1.0, 40.0, 5.0},
                         {2, 3, 9.0, 30.0, 1.0},
                         {1, 3, 1.0, 0.0, 7.0}});
      State s;
      s.x = random_nodes(4, scale, seed);
      s.v = Nodes::Zero(3, 4);
      check_derivatives(&term, s, true);
    }
  }
}

TEST(LimitSprings, OnlyPull) {
  const LimitSprings::Element e{0, 1, 1.0, 50.0, 10.0};
  Nodes x = Nodes::Zero(3, 2);
  for (const auto& [r, expected] :
       {std::pair<double, double>{1.1, 15.0}, {1.0, 10.0}, {0.9, 5.0}, {0.8, 0.0}, {0.1, 0.0}}) {
    x(0, 1) = r;
    EXPECT_NEAR(LimitSprings::tension(e, x), expected, 1e-12);
  }
}

TEST(StrainLimits, RefuseALimitThatIsNone) {
  const std::vector<SpringLink> links = {{0, 1, 0.5, 3.0, 0.0}};
  for (const double limit :
       {0.0, -0.1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(strain_limits(links, limit, 0), InputError) << limit;
  const StrainLimit l = strain_limits(links, 0.02, 7).front();
  EXPECT_NEAR(l.longest, 0.51, 1e-15);
  EXPECT_EQ(l.node[0], 7);
  EXPECT_EQ(l.node[1], 8);
}

TEST(BlockFactor, SolvesLikeADenseOne) {
  // A x = b for a random symmetric positive definite block matrix on a grid, blocks of zeros included.
  const TriangleMesh grid = make_grid(1, 1, 5, 4);
  const auto edges = edges_of(grid);
  BlockMatrix a(static_cast<int>(grid.rest.cols()), edges);
  std::mt19937 generator(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < a.rows(); ++i) a.block(a.diagonal_slot(i)).setIdentity();
  for (size_t k = 0; k < edges.size(); ++k) {
    if (k % 3 == 0) continue;
    const auto [i, j] = edges[k];
    const Mat3 g = Mat3::NullaryExpr([&] { return normal(generator); });
    const Mat3 h = g * g.transpose();  // h on both diagonals, -h between: positive semi-definite
    a.block(a.diagonal_slot(i)) += h;
    a.block(a.diagonal_slot(j)) += h;
    a.block(a.slot(i, j)) -= h;
    a.block(a.slot(j, i)) -= h;
  }
  BlockFactor factor;
  factor.analyse(a);
  ASSERT_TRUE(factor.factorise(a));
  const Nodes b = random_nodes(grid.rest.cols(), 1.0, 3);
  Nodes x = b, back;
  factor.solve(&x);
  a.multiply(x, &back);
  EXPECT_LT((back - b).norm(), 1e-12 * b.norm());
  a.block(a.diagonal_slot(7)).setZero();
  EXPECT_FALSE(factor.factorise(a));
}

/// A grid of threads of longest length 1.01 a.
std::shared_ptr<Model> limited_sheet(int cells, double limit) {
  Sheet sheet;
  sheet.size_x = sheet.size_y = 0.3;
  sheet.cells_x = sheet.cells_y = cells;
  auto model = sheet_model(sheet);
  std::vector<SpringLink> links;
  for (const StrainEdge& e : model->bodies[0].strain_edges)
    links.push_back({e.node[0], e.node[1], e.rest_length, 250.0, 0.0});
  model->strain_limits = strain_limits(links, limit, 0);
  return model;
}

double worst_stretch(const Model& model, const Nodes& x) {
  double worst = -1.0;
  for (const StrainLimit& l : model.strain_limits)
    worst = std::max(worst, (x.col(l.node[1]) - x.col(l.node[0])).norm() / l.longest - 1.0);
  return worst;
}

TEST(StrainProjection, FindsTheNearestPositionsByPullsAlone) {
  // M (x - y) = sum of pulls t n along the limits, t >= 0, t = 0 where r < l; sum m x is kept. Held nodes stay.
  auto model = limited_sheet(6, 0.01);
  for (const bool held : {false, true}) {
    Nodes y = 1.2 * model->initial.x + random_nodes(model->node_count(), 0.02, 1);
    Eigen::VectorXd inverse_mass = model->mass.cwiseInverse();
    if (held) inverse_mass[0] = inverse_mass[3] = 0.0;
    StrainProjection projection(*model);
    Nodes x = y;
    std::vector<double> impulse(model->strain_limits.size()), contact_impulse;
    if (held) y.col(3) = x.col(3) = y.col(0) + Vec3(0.1, 0.02, 0);  // within reach of each other
    const StrainLimitReport report = projection.solve(inverse_mass, {}, &x, &impulse, &contact_impulse);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.iterations, 25);
    EXPECT_LE(worst_stretch(*model, x), 5e-7);
    Nodes pulls = Nodes::Zero(3, y.cols());
    double size = 0.0;
    for (size_t k = 0; k < impulse.size(); ++k) {
      const StrainLimit& l = model->strain_limits[k];
      const Vec3 d = x.col(l.node[1]) - x.col(l.node[0]);
      EXPECT_GE(impulse[k], 0.0);
      size = std::max(size, impulse[k]);
      pulls.col(l.node[0]) += impulse[k] * d.normalized();
      pulls.col(l.node[1]) -= impulse[k] * d.normalized();
    }
    for (size_t k = 0; k < impulse.size(); ++k) {
      const StrainLimit& l = model->strain_limits[k];
      if ((x.col(l.node[1]) - x.col(l.node[0])).norm() < 0.99 * l.longest) {
        EXPECT_LT(impulse[k], 1e-3 * size);
      }
    }
    Nodes moved = (x - y) * model->mass.asDiagonal();
    for (Eigen::Index i = 0; i < y.cols(); ++i) {
      if (inverse_mass[i] > 0.0) {
        EXPECT_LT((moved.col(i) - pulls.col(i)).norm(), 2e-3 * size) << i;
      } else {
        EXPECT_EQ((x.col(i) - y.col(i)).norm(), 0.0);
      }
    }
    if (!held) {
      EXPECT_LT(moved.rowwise().sum().norm(), 1e-13 * moved.cwiseAbs().sum());
    }
  }
}

TEST(StrainProjection, LeavesAloneWhatIsWithinItsLimits) {
  auto model = limited_sheet(4, 0.01);
  Nodes x = model->initial.x;
  const Nodes y = x;
  std::vector<double> impulse(model->strain_limits.size(), 1.0), contact_impulse;
  StrainProjection projection(*model);
  const auto report = projection.solve(model->mass.cwiseInverse(), {}, &x, &impulse, &contact_impulse);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ((x - y).norm(), 0.0);
  for (double t : impulse) EXPECT_EQ(t, 0.0);
}

TEST(StrainProjection, PressesNothingIntoAPlane) {
  // A stretched sheet on the plane z = 0 whose middle has fallen through a hole, far below: its pull presses the others
  // down. They stay where they are, and so does a node that is a little behind the plane already.
  auto model = limited_sheet(6, 0.01);
  Nodes x = 1.05 * model->initial.x;
  x.row(2).setZero();
  x(2, 24) = 0.08;    // the middle is lifted: the pull on its neighbours has no part downwards only if ...
  x(2, 0) = -0.0003;  // ... and one node is a little behind the plane already
  ContactConstraints contacts;
  for (int i = 0; i < model->node_count(); ++i) {
    ContactConstraint c;
    c.node[0] = i;
    c.friction = 0.0;
    contacts.push_back(c);
  }
  contacts.erase(contacts.begin() + 24);
  StrainProjection projection(*model);
  std::vector<double> impulse(model->strain_limits.size()), contact_impulse;
  const auto report = projection.solve(model->mass.cwiseInverse(), contacts, &x, &impulse, &contact_impulse);
  EXPECT_TRUE(report.converged);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    if (i == 24) continue;
    EXPECT_GE(x(2, i), (i == 0 ? -0.0003 : 0.0) - 2e-7) << i;
  }
  EXPECT_GT(*std::max_element(contact_impulse.begin(), contact_impulse.end()), 0.0);
}

TEST(StrainProjection, LeavesContactsBetweenNodesThatNoThreadJoinsToOthers) {
  // A node over a face far away on the same sheet, pressed on it: the matrix has no blocks for them. The limits are met
  // as without the contact.
  auto model = limited_sheet(6, 0.01);
  Nodes x = 1.05 * model->initial.x, alone = x;
  ContactConstraint c;
  c.node = {48, 0, 1, 7};
  c.weight = {1.0, -0.3, -0.3, -0.4};
  c.count = 4;
  c.offset = 1.0;
  c.normal = Vec3::UnitX();
  StrainProjection projection(*model);
  std::vector<double> impulse(model->strain_limits.size()), contact_impulse;
  const Eigen::VectorXd inverse_mass = model->mass.cwiseInverse();
  EXPECT_TRUE(projection.solve(inverse_mass, {c}, &x, &impulse, &contact_impulse).converged);
  EXPECT_EQ(contact_impulse, std::vector<double>{0.0});
  EXPECT_TRUE(projection.solve(inverse_mass, {}, &alone, &impulse, &contact_impulse).converged);
  EXPECT_EQ(x, alone);
}

TEST(StrainProjection, SpreadsWhatHeldNodesMakeImpossible) {
  // Two held corners twice as far apart as the threads between them allow: finite, and said.
  auto model = limited_sheet(4, 0.01);
  Nodes x = model->initial.x;
  Eigen::VectorXd inverse_mass = model->mass.cwiseInverse();
  inverse_mass[0] = inverse_mass[4] = 0.0;
  x(0, 4) += 0.3;
  StrainProjection projection(*model);
  std::vector<double> impulse(model->strain_limits.size()), contact_impulse;
  EXPECT_FALSE(projection.solve(inverse_mass, {}, &x, &impulse, &contact_impulse).converged);
  EXPECT_TRUE(x.allFinite());
  EXPECT_LT(x.cwiseAbs().maxCoeff(), 1.0);
}

World hanging_world(std::shared_ptr<Model> model, double stiffness, const std::string& integrator, double dt) {
  WorldSettings settings;
  settings.dt = dt;
  settings.integrator = integrator;
  const int last = model->bodies[0].features.at("corner_1")[0];
  GraspRequest left = grasp_nodes("left", "towel", {0}), right = grasp_nodes("right", "towel", {last});
  left.stiffness = right.stiffness = stiffness;
  return World(std::move(model), settings, {}, {left, right});
}

/// Force of both grasps upwards over the weight.
double carried(const World& world) {
  const Snapshot s = world.snapshot();
  return -(s.grasps[0].force.z() + s.grasps[1].force.z()) / (world.model().mass.sum() * 9.81);
}

std::shared_ptr<Model> damped(std::shared_ptr<Model> model) {
  model->energies.push_back(make_mass_damping(model->mass, 5.0));
  return model;
}

TEST(LimitedTowel, WeighsItsWeightInRigidAndInSoftGrasps) {
  // At rest the grasps carry m g within 1 %, though the limits carry most of it.
  for (const double stiffness : {0.0, 300.0}) {
    World world = hanging_world(damped(limited_sheet(8, 0.001)), stiffness, "implicit_euler", 0.01);
    for (int k = 0; k < 400; ++k) ASSERT_TRUE(world.step().ok);
    EXPECT_NEAR(carried(world), 1.0, 0.01) << stiffness;
    EXPECT_LT(world.state().v.colwise().norm().maxCoeff(), 1e-3) << stiffness;
    EXPECT_GT(world.state().limit_tension.maxCoeff(), 0.05) << stiffness;
  }
}

TEST(LimitedTowel, WeighsItsWeightUnderAnExplicitScheme) {
  auto model = limited_sheet(4, 0.01);
  World world = hanging_world(damped(model), 0.0, "symplectic_euler", 1e-3);
  for (int k = 0; k < 2500; ++k) ASSERT_TRUE(world.step().ok);
  double sum = 0.0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(world.step().ok);
    sum += carried(world) / 100.0;
  }
  EXPECT_NEAR(sum, 1.0, 0.01);
  EXPECT_LE(worst_stretch(*model, world.state().x), 1e-6);
}

TEST(LimitedTowel, ContinuesToTheBitFromItsState) {
  // Tensions belong to the state: the same state gives the same next step. A reset starts from none.
  World a = hanging_world(limited_sheet(6, 0.001), 0.0, "implicit_euler", 0.01);
  World b = hanging_world(limited_sheet(6, 0.001), 0.0, "implicit_euler", 0.01);
  for (int k = 0; k < 30; ++k) {
    a.step();
    b.step();
  }
  EXPECT_TRUE(same_state(a.state(), b.state()));
  EXPECT_GT(a.state().limit_tension.maxCoeff(), 0.0);
  a.apply(command::Reset{});
  b.apply(command::Reset{});
  for (int k = 0; k < 30; ++k) a.step();
  World c = hanging_world(limited_sheet(6, 0.001), 0.0, "implicit_euler", 0.01);
  for (int k = 0; k < 30; ++k) c.step();
  EXPECT_TRUE(same_state(a.state(), c.state()));
}

TEST(LimitedTowel, IsSlackAtOnceWhenItIsLetGo) {
  // In free fall after a hard pull nothing contracts: the tension of the last step is gone within a few steps.
  World world = hanging_world(limited_sheet(6, 0.001), 0.0, "implicit_euler", 0.01);
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(world.step().ok);
  world.apply(command::Release{});
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(world.step().ok);
  EXPECT_LT(world.state().limit_tension.maxCoeff(), 0.05);
  EXPECT_LE(worst_stretch(world.model(), world.state().x), 1e-6);
}

TEST(LimitedTowel, HangsOverATableWithoutCreeping) {
  // Half of a soft sheet hangs over the edge; friction holds the rest (mu 1 > tan of what hangs): it stays.
  Sheet sheet;
  sheet.size_x = 0.3;
  sheet.size_y = 0.1;
  sheet.cells_x = 15;
  sheet.cells_y = 5;
  sheet.membrane = 20.0;
  sheet.bend = 0.0;
  sheet.friction = 1.0;
  sheet.position = Vec3(0.06, 0, 0.502);
  sheet.mass_damping = 3.0;
  auto model = sheet_model(sheet);
  std::vector<SpringLink> links;
  for (const StrainEdge& e : model->bodies[0].strain_edges)
    links.push_back({e.node[0], e.node[1], e.rest_length, 20.0, 0.0});
  model->strain_limits = strain_limits(links, 0.01, 0);
  Collider table = collider("table", Shape::Type::kBox, Vec3(0.4, 0.4, 0.5), at(-0.1, 0, 0.25));
  table.friction = 1.0;
  WorldSettings settings;
  World world(model, settings, {table}, {});
  double deepest = 0.0;
  const auto run = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      ASSERT_TRUE(world.step().ok);
      deepest = std::max(deepest, world.snapshot().max_penetration);
    }
  };
  run(200);
  const double before = world.state().x.row(0).minCoeff();
  run(200);
  EXPECT_NEAR(world.state().x.row(0).minCoeff(), before, 1e-3);  // 0.5 mm/s of regularised friction
  EXPECT_LT(deepest, 1e-3);
  EXPECT_LE(worst_stretch(*model, world.state().x), 1e-6);
}

TEST(World, WithoutLimitsHasNoTensions) {
  Sheet sheet;
  sheet.cells_x = sheet.cells_y = 3;
  World world(sheet_model(sheet), {}, {}, {});
  world.step();
  EXPECT_EQ(world.state().limit_tension.size(), 0);
  for (const BillItem& item : world.bill()) EXPECT_EQ(item.part.find("limit"), std::string::npos);
}

TEST(World, PaysForItsLimits) {
  World world = hanging_world(limited_sheet(3, 0.01), 0.0, "implicit_euler", 0.01);
  world.step();
  int lines = 0;
  for (const BillItem& item : world.bill())
    if (item.part.find("strain limit") != std::string::npos) ++lines;
  EXPECT_EQ(lines, 2);
}

TEST(World, WarnsOfLimitsThatCannotBeMet) {
  World world = hanging_world(limited_sheet(4, 0.01), 0.0, "implicit_euler", 0.01);
  Pose target = Pose::Identity();
  target.translation() = Vec3(0.45, -0.15, 0);  // the corner at 0.15 is drawn 0.3 m away
  ASSERT_TRUE(world.apply(command::MoveGrasp{"right", target, 0.5}).status.ok());
  for (int k = 0; k < 80; ++k) ASSERT_TRUE(world.step().ok);
  const auto warnings = world.snapshot().warnings;
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(),
                          [](const std::string& w) { return w.find("strain limit") != std::string::npos; }));
}

}  // namespace
}  // namespace deformable_sim::test
