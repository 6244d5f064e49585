// Coulomb friction of every scheme against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "support/system.h"

namespace deformable_sim::test {
namespace {

constexpr double kStep = 1e-3;  // s

/// A point mass on a plane through the origin, tilted by `angle` about y: downhill is -x rotated.
class Slider {
 public:
  Slider(const std::string& scheme, double friction, double angle)
      : body_(Vec3(0, 0, 0), Eigen::VectorXd::Constant(1, 0.3)),
        integrator_(make_integrator(scheme, exact_settings(1e-9))),
        friction_(friction),
        normal_(std::sin(angle), 0, std::cos(angle)),
        downhill_(std::cos(angle), 0, -std::sin(angle)) {
    body_.add_gravity();
  }
  void push(double speed) { body_.state.v = speed * downhill_; }
  void run(double seconds) {
    for (int k = 0; k < std::lround(seconds / kStep); ++k) {
      ContactConstraint c;
      c.node[0] = 0;
      c.normal = normal_;
      c.friction = friction_;
      c.surface_velocity = surface_velocity;
      c.stuck = stuck_;
      body_.dynamics.contacts.assign(1, c);
      body_.step(*integrator_, kStep);
      stuck_ = body_.dynamics.contacts[0].stuck;
    }
  }
  double travelled() const { return downhill_.dot(Vec3(body_.state.x)); }
  double speed() const { return downhill_.dot(Vec3(body_.state.v)); }
  double depth() const { return -normal_.dot(Vec3(body_.state.x)); }
  Vec3 contact_force() const { return body_.dynamics.contacts[0].force; }

  Vec3 surface_velocity = Vec3::Zero();

 private:
  System body_;
  std::unique_ptr<Integrator> integrator_;
  double friction_;
  Vec3 normal_, downhill_;
  Vec3 stuck_ = Vec3::Zero();
};

class Friction : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Registry, Friction, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(Friction, SticksBelowTheAngleOfFrictionAndSlidesAboveIt) {
  // tan theta < mu: rest, creep below 1e-4 m/s. Above: a = g (sin theta - mu cos theta) within 2 %.
  for (const double mu : {0.1, 0.3, 0.5, 0.7, 1.0}) {
    for (const double degrees : {3.0, 10.0, 20.0, 30.0, 40.0}) {
      SCOPED_TRACE("mu " + std::to_string(mu) + ", angle " + std::to_string(degrees));
      const double angle = degrees * M_PI / 180.0;
      Slider slider(GetParam(), mu, angle);
      slider.run(0.1);
      const double start_speed = slider.speed(), start = slider.travelled();
      slider.run(0.3);
      if (std::tan(angle) < mu) {
        EXPECT_LT(std::abs(slider.speed()), 1e-4);
        EXPECT_LT(std::abs(slider.travelled() - start), 0.3 * 1e-4);
      } else {
        const double expected = kGravity * (std::sin(angle) - mu * std::cos(angle));
        EXPECT_NEAR((slider.speed() - start_speed) / 0.3, expected, 0.02 * expected);
        EXPECT_GT(start_speed, 0.0);
      }
      EXPECT_LT(std::abs(slider.depth()), 1e-5);
    }
  }
}

TEST_P(Friction, StopsAfterTheDistanceOfTheory) {
  // d = v0^2 / (2 mu g) within 1 %.
  for (const double mu : {0.2, 0.4, 0.7}) {
    Slider slider(GetParam(), mu, 0.0);
    slider.push(2.0);
    slider.run(2.0 / (mu * kGravity) + 0.2);
    const double expected = 4.0 / (2.0 * mu * kGravity);
    EXPECT_NEAR(slider.travelled(), expected, 0.01 * expected) << mu;
    EXPECT_LT(std::abs(slider.speed()), 1e-4) << mu;
  }
}

TEST_P(Friction, ReportsTheForceOnTheBody) {
  // At rest on a slope the contact carries the whole weight: m g upwards.
  Slider slider(GetParam(), 0.7, 0.3);
  slider.run(0.3);
  EXPECT_LT((slider.contact_force() - Vec3(0, 0, 0.3 * kGravity)).norm(), 0.01 * 0.3 * kGravity);
}

TEST_P(Friction, CarriesABodyAlongWithAMovingSurface) {
  // Accelerated at mu g until it moves with the belt.
  Slider slider(GetParam(), 0.5, 0.0);
  slider.surface_velocity = Vec3(0.4, 0, 0);
  slider.run(0.04);
  EXPECT_NEAR(slider.speed(), 0.5 * kGravity * 0.04, 0.03 * 0.2);
  slider.run(0.2);
  EXPECT_NEAR(slider.speed(), 0.4, 2e-4);
}

}  // namespace
}  // namespace deformable_sim::test
