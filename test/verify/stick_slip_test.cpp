// Friction of whole worlds, through the contact search: what sticks stays, what slides slides as it should.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/small_worlds.h"
#include "support/system.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

struct Configuration {
  std::string integrator;
  double rate;  // steps a second
};

void PrintTo(const Configuration& c, std::ostream* out) {
  *out << c.integrator << " at " << c.rate << " Hz";
}

class StickSlip : public testing::TestWithParam<Configuration> {
 protected:
  double dt() const { return 1.0 / GetParam().rate; }
  WorldSettings settings() const {
    WorldSettings s;
    s.dt = dt();
    s.integrator = GetParam().integrator;
    s.solver = exact_settings(1e-7);
    return s;
  }
  std::string name(const std::string& what) const {
    return what + ", " + GetParam().integrator + " at " + std::to_string(std::lround(GetParam().rate)) + " Hz";
  }
  void run(World* world, double seconds) const {
    for (int k = 0; k < std::lround(seconds / dt()); ++k) ASSERT_TRUE(world->step().ok);
  }
};

std::vector<Configuration> configurations() {
  std::vector<Configuration> all;
  for (const char* integrator : {"implicit_euler", "bdf2", "tr_bdf2", "substepped_verlet"})
    for (const double rate : {240.0, 120.0, 60.0}) all.push_back({integrator, rate});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Schemes, StickSlip, testing::ValuesIn(configurations()), [](const auto& info) {
  return info.param.integrator + "_" + std::to_string(std::lround(info.param.rate));
});

Collider plane(double angle, double friction) {
  Collider c = collider("slope", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, 0, angle, Vec3(0, 1, 0)));
  c.friction = friction;
  return c;
}

std::shared_ptr<Model> points(const Nodes& x, double friction) {
  auto model = points_model(x, 0.3, Vec3(0, 0, -kGravity));
  model->bodies[0].friction = friction;
  model->bodies[0].contact_radius = 0.0;
  return model;
}

TEST_P(StickSlip, RestsBelowTheAngleOfFrictionAndSlidesAboveIt) {
  // tan theta < mu: rest, and no creep. Above: a = g (sin theta - mu cos theta) within 2 %.
  for (const double mu : {0.1, 0.3, 0.5, 0.7, 1.0}) {
    const double limit = std::atan(mu) * 180.0 / M_PI;
    for (const double degrees : {3.0, 10.0, 20.0, 30.0, 40.0, limit - 0.5, limit + 0.5}) {
      SCOPED_TRACE("mu " + std::to_string(mu) + ", angle " + std::to_string(degrees));
      const double angle = degrees * M_PI / 180.0;
      World world(points(Nodes(Vec3::Zero()), mu), settings(), {plane(angle, mu)}, {});
      const Vec3 downhill(std::cos(angle), 0, -std::sin(angle));
      run(&world, 0.5);
      const double start = downhill.dot(Vec3(world.state().x)), speed = downhill.dot(Vec3(world.state().v));
      run(&world, 2.0);
      const double travelled = downhill.dot(Vec3(world.state().x)) - start;
      if (std::tan(angle) < mu) {
        EXPECT_LT(std::abs(start), 2e-4);  // the first step falls freely by g dt^2 / 2 where speeds are known ahead
        EXPECT_LT(std::abs(travelled), 2.0 * 1e-9);
      } else {
        const double expected = kGravity * (std::sin(angle) - mu * std::cos(angle));
        const double gained = downhill.dot(Vec3(world.state().v)) - speed;
        check("H1", name("incline, m/s^2, mu " + std::to_string(mu) + ", " + std::to_string(degrees) + " degrees"),
              gained / 2.0, expected, 0.02);
      }
    }
  }
}

TEST_P(StickSlip, StopsAfterTheDistanceOfTheory) {
  // d = v0^2 / (2 mu g); a first-order step errs by v0 dt / 2 at most: 1 % beside that.
  for (const double mu : {0.2, 0.4, 0.7}) {
    const auto model = points(Nodes(Vec3::Zero()), mu);
    model->initial.v(0, 0) = 2.0;
    World world(model, settings(), {plane(0.0, mu)}, {});
    const double expected = 4.0 / (2.0 * mu * kGravity);
    run(&world, 2.0 / (mu * kGravity) + 0.3);
    check("H2", name("stopping distance, m, mu " + std::to_string(mu)), world.state().x(0, 0), expected,
          0.01 * expected + 1.0 * dt(), Tolerance::kAbsolute);
    EXPECT_LT(world.state().v.norm(), 1e-6) << mu;
  }
}

TEST_P(StickSlip, SlipsFromATurntableBeyondTheRadiusOfTheory) {
  // Friction holds a point while omega^2 r < mu g: r = mu g / omega^2. Chords bring (omega dt)^2 / 12 = 0.04 %. Schemes
  // that take a step in parts (TR-BDF2's stages, the half kicks of Verlet) meet the turn from one chord to the next in
  // the first part, and are promised half the radius only.
  const bool whole = GetParam().integrator == "implicit_euler" || GetParam().integrator == "bdf2";
  const double mu = 0.5, omega = 4.0, radius = mu * kGravity / (omega * omega);
  const double factors[] = {0.5, 0.9, 0.98, 1.02, 1.1};
  Nodes x = Nodes::Zero(3, 5), v = Nodes::Zero(3, 5);
  for (int i = 0; i < 5; ++i) {
    x(0, i) = factors[i] * radius;
    v(1, i) = factors[i] * radius * omega;
  }
  const auto model = points(x, mu);
  model->initial.v = v;
  Collider table = collider("table", Shape::Type::kCylinder, Vec3(1.0, 0.1, 0), at(0, 0, -0.05));
  table.friction = mu;
  World world(model, settings(), {table}, {});
  const double quarter = std::floor(0.5 * M_PI / omega / dt()) * dt();
  double angle = 0.0;
  for (int k = 0; k < 8; ++k) {
    angle += omega * quarter;
    ASSERT_TRUE(
        world.apply(command::MoveCollider{"table", at(0, 0, -0.05, angle, Vec3(0, 0, 1)), quarter}).status.ok());
    run(&world, quarter);
  }
  for (int i = 0; i < 5; ++i) {
    const double r = factors[i] * radius;
    const Vec3 stuck(r * std::cos(angle), r * std::sin(angle), 0.0);
    const double slipped = (world.state().x.col(i) - stuck).norm();
    if (factors[i] <= (whole ? 1.0 : 0.5)) {
      EXPECT_LT(slipped, 1e-4) << factors[i];
    } else if (factors[i] > 1.0) {
      EXPECT_GT(slipped, 1e-2) << factors[i];
    }
  }
}

TEST_P(StickSlip, ABeltDragsAHeldSheetWithMuTimesItsWeight) {
  // F = mu (m - m_held) g on the grasp, within 0.5 %.
  Sheet sheet;
  sheet.size_x = sheet.size_y = 0.2;
  sheet.cells_x = sheet.cells_y = 8;
  sheet.position = Vec3(0, 0, 0.001);
  sheet.damping_time = 0.01;
  const auto model = sheet_model(sheet);
  std::vector<int> edge;
  double free_mass = 0.0;
  for (int i = 0; i < model->node_count(); ++i) {
    if (model->initial.x(0, i) < -0.0999) {
      edge.push_back(i);
    } else {
      free_mass += model->mass[i];
    }
  }
  World world(model, settings(), {plane(0.0, 0.5)}, {grasp_nodes("hand", "towel", edge)});
  ASSERT_TRUE(world.apply(command::MoveCollider{"slope", at(1.2, 0, 0), 6.0}).status.ok());
  run(&world, 3.0);
  double mean = 0.0;
  const int samples = static_cast<int>(std::lround(1.0 / dt()));
  for (int k = 0; k < samples; ++k) {
    ASSERT_TRUE(world.step().ok);
    mean += world.grasp_reports()[0].force.x() / samples;
  }
  const double expected = 0.5 * free_mass * kGravity;
  check("H5", name("dragged sheet, N"), mean, expected, 0.005);
}

TEST_P(StickSlip, ARestingTowelPressesWithItsWeight) {
  // Sum of the normal forces = m g.
  Sheet sheet;
  sheet.size_x = sheet.size_y = 0.2;
  sheet.cells_x = sheet.cells_y = 8;
  sheet.position = Vec3(0, 0, 0.02);
  const auto model = sheet_model(sheet);
  World world(model, settings(), {plane(0.0, 0.5)}, {});
  run(&world, 1.0);
  double pressed = 0.0;
  for (const ContactReport& c : world.contact_reports()) {
    pressed += c.force.dot(c.normal);
    EXPECT_EQ(c.collider, 0);
    EXPECT_NEAR(c.point.z(), 0.0, 1e-12);
    EXPECT_NEAR(c.distance, 0.0, 1e-4);
  }
  const double weight = model->mass.sum() * kGravity;
  check("H5", name("weight of a resting towel, N"), pressed, weight, 0.01);
}

TEST_P(StickSlip, ForcesOfContactsAndWeightChangeTheMomentum) {
  // dp = dt (sum of contact forces + m g), to the tolerance of the solve (1e-9 m/s^2 of g).
  Sheet sheet;
  sheet.size_x = sheet.size_y = 0.2;
  sheet.cells_x = sheet.cells_y = 6;
  sheet.position = Vec3(0.001 * std::sin(0.6), 0, 0.001 * std::cos(0.6));
  const auto model = sheet_model(sheet);
  const Mat3 tilt = at(0, 0, 0, 0.6, Vec3(0, 1, 0)).linear();
  model->initial.x = (tilt * model->bodies[0].surface->rest).colwise() + sheet.position;
  model->initial.v.row(1).setConstant(0.3);
  WorldSettings exact = settings();
  exact.solver = exact_settings(1e-9);
  World world(model, exact, {plane(0.6, 0.4)}, {});
  const double mass = model->mass.sum();
  for (int k = 0; k < 60; ++k) {
    const Vec3 before = world.state().v * model->mass;
    ASSERT_TRUE(world.step().ok);
    if (world.snapshot().substeps > 1) continue;
    Vec3 impulse = dt() * mass * Vec3(0, 0, -kGravity);
    for (const ContactReport& c : world.contact_reports()) impulse += dt() * c.force;
    const Vec3 change = world.state().v * model->mass - before;
    EXPECT_LT((change - impulse).norm(), 1e-9 * mass * kGravity * dt() + 1e-9 * dt() * mass) << k;
  }
}

/// A sheet of 20 x 20 cells on a slope, mu = 0.5.
std::unique_ptr<World> cloth_on_slope(const std::string& step, double angle) {
  char text[1500];
  std::snprintf(text, sizeof text,
                "bodies:\n"
                "  - cloth: {name: towel, size: [0.4, 0.4], cells: [20, 20], friction: 0.5, contact_radius: 0.001,\n"
                "      pose: {position: [%.12f, 0, %.12f], rpy: [0, %.12f, 0]}, bending: quadratic,\n"
                "      material: {areal_density: 0.2, thickness: 0.001, youngs_modulus: 1.0e5, damping: 0.003,\n"
                "                 bending_rigidity: [1.0e-5, 1.0e-5]}}\n"
                "colliders:\n"
                "  - plane: {name: slope, friction: 0.5, pose: {rpy: [0, %.12f, 0]}}\n"
                "step: {%s}\n",
                0.001 * std::sin(angle), 0.001 * std::cos(angle), angle, angle, step.c_str());
  return build_world(load_scene_text(text, "slope.yaml"));
}

class ClothOnASlope : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Schemes, ClothOnASlope,
                         testing::Values("implicit_euler, linear_solver: multigrid", "bdf2, linear_solver: multigrid",
                                         "tr_bdf2, linear_solver: multigrid", "substepped_verlet", "line_dual"),
                         [](const auto& info) { return info.param.substr(0, info.param.find(',')); });

TEST_P(ClothOnASlope, StaysForTenSecondsBelowTheAngleOfFriction) {
  // No node moves: 1e-9 m/s is what single precision of the inner solves leaves of it.
  for (const char* dt : {"0.00416666667", "0.0166666667"}) {
    const auto world = cloth_on_slope("dt: " + std::string(dt) + ", integrator: " + GetParam(), 20.0 * M_PI / 180.0);
    const auto second = std::lround(1.0 / world->settings().dt);
    for (long k = 0; k < second; ++k) ASSERT_TRUE(world->step().ok);
    const Nodes start = world->state().x;
    for (long k = 0; k < 9 * second; ++k) ASSERT_TRUE(world->step().ok);
    EXPECT_LT((world->state().x - start).cwiseAbs().maxCoeff(), 9.0 * 1e-9) << dt;
  }
}

TEST_P(ClothOnASlope, SlidesAboveItAsABlockDoes) {
  // a = g (sin theta - mu cos theta) within 2 %.
  const double angle = 35.0 * M_PI / 180.0;
  for (const char* dt : {"0.00416666667", "0.0166666667"}) {
    const auto world = cloth_on_slope("dt: " + std::string(dt) + ", integrator: " + GetParam(), angle);
    const Vec3 downhill(std::cos(angle), 0, -std::sin(angle));
    const auto half = std::lround(0.5 / world->settings().dt);
    for (long k = 0; k < half; ++k) ASSERT_TRUE(world->step().ok);
    const double speed = (world->state().v.transpose() * downhill).mean();
    for (long k = 0; k < 2 * half; ++k) ASSERT_TRUE(world->step().ok);
    const double gained = (world->state().v.transpose() * downhill).mean() - speed;
    const double expected = kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
    EXPECT_NEAR(gained / (2.0 * static_cast<double>(half) * world->settings().dt), expected, 0.02 * expected) << dt;
  }
}

}  // namespace
}  // namespace deformable_sim::test
