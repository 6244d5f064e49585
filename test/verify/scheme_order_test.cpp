// E5: the observed order of every scheme, over five halvings of the step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/point_force.h"
#include "support/slope.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

using Problem = std::function<Nodes(const std::string& scheme, int steps)>;

/// Newton as exact as rounding allows: positions of 1 m are known to 1e-16, accelerations to that over dt^2.
std::unique_ptr<Integrator> exact_scheme(const std::string& name, double dt) {
  return make_integrator(name, exact_settings(std::max(1e-9, 2e-15 / (dt * dt))));
}

/// Slope of log |error| over log dt for steps halved five times from 1 / first.
double observed_order(const std::string& scheme, int first, const Problem& end, const Nodes& exact) {
  std::vector<double> steps, errors;
  for (int k = 0; k < 6; ++k) {
    const int count = first << k;
    steps.push_back(1.0 / count);
    errors.push_back((end(scheme, count) - exact).norm());
  }
  return log_slope(steps, errors);
}

/// Three springs, swinging and stretching; `damping` in N s/m, nonlinear in the positions too.
std::unique_ptr<System> swinging_chain(double damping) {
  const Polyline line = make_line(1.0, 3);
  auto chain = std::make_unique<System>(line.rest, Eigen::Vector4d(0.1, 0.2, 0.1, 0.3));
  std::vector<SpringLink> links;
  for (int i = 0; i < 3; ++i) links.push_back({i, i + 1, 1.0 / 3.0, 20.0, damping});
  chain->add(make_springs("springs", links, 0)).add_gravity().hold(0);
  return chain;
}

Nodes end_of_swing(const std::string& scheme, int steps, double damping) {
  auto chain = swinging_chain(damping);
  const auto integrator = exact_scheme(scheme, 0.2 / steps);
  for (int k = 0; k < steps; ++k) chain->step(*integrator, 0.2 / steps);
  return chain->state.x;
}

/// The held end moves along a smooth path that the scheme is told at the ends of its steps.
Nodes end_of_pull(const std::string& scheme, int steps) {
  auto chain = swinging_chain(0.1);
  const Vec3 start = chain->state.x.col(0);
  const auto integrator = exact_scheme(scheme, 0.2 / steps);
  for (int k = 1; k <= steps; ++k) {
    const double t = 0.2 * k / steps;
    chain->dynamics.kinematics.target.col(0) = start + Vec3(0.0, 2.0 * t * t, std::sin(8.0 * t) - 8.0 * t);
    chain->step(*integrator, 0.2 / steps);
  }
  return chain->state.x;
}

/// x'' = -4 x - x' |x'| + (cos 3t, sin 2t, t^2): depends on everything a force may depend on.
Nodes end_of_driven_motion(const std::string& scheme, int steps) {
  System body(Vec3(1, 0, 0.5), Eigen::VectorXd::Ones(1));
  body.state.v.col(0) = Vec3(0, 1, -0.5);
  body.add(std::make_unique<PointForce>(
      [](const Vec3& x, const Vec3& v, double t) {
        return Vec3(-4.0 * x - v.norm() * v + Vec3(std::cos(3 * t), std::sin(2 * t), t * t));
      },
      [](const Vec3&, const Vec3& v, double) {
        const double speed = v.norm() + 1e-12;
        const Mat3 by_v = -(speed * Mat3::Identity() + v * v.transpose() / speed);
        return std::pair<Mat3, Mat3>(-4.0 * Mat3::Identity(), by_v);
      }));
  const auto integrator = exact_scheme(scheme, 1.0 / steps);
  for (int k = 0; k < steps; ++k) body.step(*integrator, 1.0 / steps);
  return body.state.x;
}

class SchemeOrder : public testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Integrator> scheme() const { return make_integrator(GetParam(), {}); }
  void expect_order(const std::string& problem, int order, int first, const Problem& end, int reference) const {
    const double found = observed_order(GetParam(), first, end, end("rk4", reference));
    check("E5", GetParam() + ", order, " + problem, found, order, 0.1, Tolerance::kAbsolute);
  }
};
INSTANTIATE_TEST_SUITE_P(Registry, SchemeOrder, testing::ValuesIn(integrator_names()),
                         [](const auto& info) { return info.param; });

TEST_P(SchemeOrder, ConvergesOnASmoothMotion) {
  const auto end = [](const std::string& name, int steps) { return end_of_swing(name, steps, 0.0); };
  const int order = scheme()->order();
  expect_order("smooth motion", order, order == 1 ? 100 : order == 2 ? 50 : 20, end, 4000);
}

TEST_P(SchemeOrder, ConvergesWithDampers) {
  const auto end = [](const std::string& name, int steps) { return end_of_swing(name, steps, 0.4); };
  const int order = scheme()->order_with_velocity_forces();
  expect_order("dampers", order, order == 1 ? 100 : order == 2 ? 50 : 20, end, 4000);
}

TEST_P(SchemeOrder, ConvergesWhereForcesDependOnVelocityAndTime) {
  const int order = scheme()->order_with_velocity_forces();
  expect_order("forces of velocity and time", order,
               order == 1   ? 100
               : order == 2 ? 50
                            : 10,
               &end_of_driven_motion, 4000);
}

TEST_P(SchemeOrder, ConvergesUnderPrescribedMotion) {
  // Between the ends of a step a prescribed node moves straight: second order at most, reference on a much finer path.
  const int order = std::min(2, scheme()->order_with_velocity_forces());
  expect_order("prescribed motion", order, order == 1 ? 100 : 25, &end_of_pull, 20000);
}

TEST(Bdf2, KeepsItsOrderWhenTheStepVaries) {
  // Steps that alternate 1 : 1.8, never beyond the factor 2 at which it would begin anew.
  const auto end = [](const std::string& name, int steps) {
    auto chain = swinging_chain(0.1);
    const auto integrator = exact_scheme(name, 0.2 / steps);
    for (int k = 0; k < steps; ++k) chain->step(*integrator, 0.2 / steps * (k % 2 == 0 ? 2.0 : 3.6) / 2.8);
    return chain->state.x;
  };
  const Nodes exact = end("rk4", 4000);
  check("E5", "bdf2, order, steps 1 : 1.8", observed_order("bdf2", 50, end, exact), 2.0, 0.1, Tolerance::kAbsolute);
}

TEST(Bdf2, KeepsItsOrderWhenItBeginsAnew) {
  // A step three times the last is one of TR-BDF2, of the same order.
  const auto end = [](const std::string& name, int steps) {
    auto chain = swinging_chain(0.1);
    const auto integrator = exact_scheme(name, 0.2 / steps);
    for (int k = 0; k < steps; ++k) chain->step(*integrator, 0.2 / steps * (k % 2 == 0 ? 0.5 : 1.5));
    return chain->state.x;
  };
  const Nodes exact = end("rk4", 4000);
  check("E5", "bdf2, order, steps 1 : 3", observed_order("bdf2", 50, end, exact), 2.0, 0.1, Tolerance::kAbsolute);
}

}  // namespace
}  // namespace deformable_sim::test
