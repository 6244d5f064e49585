// Bending of a line that is free to twist, and the solver that ropes get.
#include <gtest/gtest.h>

#include "deformable_sim/core/energy/terms.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim::test {
namespace {

Polyline uneven_line() {
  Polyline line = make_line(1.0, 6);
  line.rest.row(0) = line.rest.row(0).array() + 0.3 * line.rest.row(0).array().square();
  return line;
}

TEST(LineBending, HoldsTheEnergyOfAnArc) {
  // E = B l / (2 R^2); the chord of a segment h on the arc is 2 R sin(h / 2R): h^2 / 12 R^2 = 1e-4 at most here.
  const int n = 200;
  Polyline line = make_line(1.0, n);
  const auto bending = make_line_bending(line, 2.0, 0.0, 0);
  State s;
  s.x.resize(3, n + 1);
  const double radius = 0.4;
  for (int i = 0; i <= n; ++i) {
    const double phi = static_cast<double>(i) / n / radius;
    s.x.col(i) = radius * Vec3(std::cos(phi), 0.6 * std::sin(phi), 0.8 * std::sin(phi));
  }
  const double joints = static_cast<double>(n - 1) / n;  // the half segments at the ends have none
  EXPECT_NEAR(bending->value(s), joints * 2.0 / (2.0 * radius * radius), 1e-4 * bending->value(s));
}

TEST(LineBending, HasTheForceAndJacobianOfItsEnergy) {
  // Quadratic: f(x) = -W x - damping W v, E = x.W x / 2, so that f.x = -2 E exactly; A -= dx df/dx + dv df/dv adds
  // (dx + damping dv) W.
  const Polyline line = uneven_line();
  const auto bending = make_line_bending(line, 0.7, 0.03, 0);
  const auto n = static_cast<int>(line.rest.cols());
  State s;
  s.x.resize(3, n);
  for (Eigen::Index i = 0; i < s.x.size(); ++i) s.x.data()[i] = std::sin(1.7 * static_cast<double>(i));
  s.v = Nodes::Zero(3, n);
  Nodes f = Nodes::Zero(3, n);
  bending->add_force(s, &f);
  EXPECT_NEAR(f.cwiseProduct(s.x).sum(), -2.0 * bending->value(s), 1e-12 * bending->value(s));
  std::vector<std::array<int, 2>> pairs;
  bending->add_pattern(&pairs);
  BlockMatrix a(n, pairs);
  bending->bind(a);
  bending->add_jacobian(s, 1.0, 0.0, Jacobian::kProjected, &a);
  Nodes product;
  a.multiply(s.x, &product);
  EXPECT_LT((product + f).norm(), 1e-12 * f.norm());
  s.v = s.x;
  Nodes damped = Nodes::Zero(3, n);
  bending->add_force(s, &damped);
  EXPECT_LT((damped - 1.03 * f).norm(), 1e-12 * f.norm());
  a.set_zero();
  bending->add_jacobian(s, 1.0, 2.0, Jacobian::kProjected, &a);
  a.multiply(s.x, &product);
  EXPECT_LT((product + 1.06 * f).norm(), 1e-12 * f.norm());
}

TEST(LineBending, DoesNotFeelRigidMotion) {
  const Polyline line = uneven_line();
  const auto bending = make_line_bending(line, 0.7, 0.0, 0);
  State s;
  s.x = (Eigen::AngleAxisd(0.8, Vec3(1, 2, 3).normalized()).toRotationMatrix() * line.rest).colwise() + Vec3(1, -2, 5);
  s.v = Nodes::Zero(3, line.rest.cols());
  Nodes f = Nodes::Zero(3, line.rest.cols());
  bending->add_force(s, &f);
  EXPECT_LT(f.norm(), 1e-9);
}

/// A rope held by one end swings down.
std::unique_ptr<World> whip(const std::string& step, double axial, const std::string& more = "") {
  return build_world(load_scene_text(
      "step: {" + step +
          "}\nair: {damping: 0.2}\nbodies:\n  - rope: {name: r, segments: 60, length: 1, model: untwisted, " +
          "pose: {position: [0, 0, 1]}, " + (more.empty() ? "pins: [end_0], " : "") +
          "friction: 0.5, material: {linear_density: 0.05, damping: 0, " + "axial_stiffness: " + std::to_string(axial) +
          ", bending_rigidity: [1.0e-5, 1.0e-5]}}\n" + more,
      "whip.yaml"));
}

double largest_distance(const World& a, const World& b) {
  return (a.state().x - b.state().x).colwise().norm().maxCoeff();
}

TEST(FullNewtonSteps, NeedNoMoreOfThemForAStiffRope) {
  // k n n^T with the tension of the start: what Newton has to iterate away is the turning of segments, not their
  // strain.
  for (const double axial : {1e3, 1e5, 1e7}) {
    const auto world = whip("dt: 0.0041666666, integrator: bdf2", axial);
    int iterations = 0;
    for (int k = 0; k < 240; ++k) {
      const StepOutcome outcome = world->step();
      ASSERT_TRUE(outcome.ok);
      EXPECT_TRUE(outcome.report.converged) << axial << ", step " << k;
      iterations += outcome.report.newton_iterations;
    }
    EXPECT_LT(iterations, 3 * 240) << axial;
    EXPECT_LT(world->snapshot().bodies[0].max_strain, 3.0 / axial + 1e-9)
        << "some six times the weight, 0.5 N, at the grip";
  }
}

TEST(FullNewtonSteps, EndWhereALineSearchDoes) {
  // The same equations, solved to 1e-7 m/s^2 by another solver, another matrix and another way to step: ten steps apart
  // by 1e-7 tau^2 each and what rounding makes of it.
  const auto full = whip("dt: 0.002, integrator: bdf2, tolerance: 1.0e-7, newton_iterations: 50", 1e3);
  const auto searched =
      whip("dt: 0.002, integrator: bdf2, tolerance: 1.0e-7, newton_iterations: 200, linear_solver: direct", 1e3);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(full->step().report.converged) << k;
    ASSERT_TRUE(searched->step().report.converged) << k;
  }
  EXPECT_LT(largest_distance(*full, *searched), 1e-9);
}

TEST(BandedSolver, DragsARopeOverACylinderAsConjugateGradientsDo) {
  // Contacts couple neighbours within the band: only the linear solver differs, each step is solved to 1e-5 m/s^2.
  const std::string bar =
      "grasps:\n  - {name: hand, body: r, select: {feature: end_0}, max_speed: 1}\n"
      "colliders:\n  - cylinder: {name: bar, radius: 0.1, length: 0.5, friction: 0.3, "
      "pose: {position: [0.1, 0, 0.86], rpy: [1.5708, 0, 0]}}\n";
  const std::string step =
      "dt: 0.002, tolerance: 1.0e-5, newton_iterations: 60, jacobian: projected, linear_tolerance: 1.0e-6, "
      "linear_solver: ";
  const auto banded = whip(step + "banded", 1e3, bar), iterative = whip(step + "cg", 1e3, bar);
  bool touched = false;
  for (int k = 0; k < 60; ++k) {
    ASSERT_TRUE(banded->step().ok);
    ASSERT_TRUE(iterative->step().ok);
    touched = touched || banded->snapshot().bodies[0].contacts > 0;
  }
  EXPECT_TRUE(touched);
  EXPECT_LT(largest_distance(*banded, *iterative), 1e-6);
}

}  // namespace
}  // namespace deformable_sim::test
