// What must not happen to rods: free fall and rigid motion deform nothing, and no direction of space is preferred.
#include <gtest/gtest.h>

#include <cmath>

#include "support/rods.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr int kSegments = 12;

/// A damped spiral of unequal bending stiffnesses at rest, 0.6 m of cable.
RodSystem spiral(const Mat3& rotation, double damping) {
  Polyline line;
  line.rest.resize(3, kSegments + 1);
  for (int i = 0; i <= kSegments; ++i)
    line.rest.col(i) = rotation * Vec3(0.1 * std::cos(0.5 * i), 0.1 * std::sin(0.5 * i), 0.02 * i);
  RodSection section;
  section.stretch = 100.0;
  section.bend_1 = 0.01;
  section.bend_2 = 0.03;
  section.twist = 0.008;
  section.damping = damping;
  section.radius_of_gyration = 0.01;
  section.linear_density = 0.1;
  return RodSystem(line, section, rest_as_drawn(line, rotation * Vec3::UnitZ()));
}

TEST(RodNull, AFallingRodKeepsItsShape) {
  // F39: every node of a rod at rest falls alike, whatever the scheme: to 1e-10 m in 0.05 s.
  for (const std::string& name : integrator_names()) {
    if (takes_known_terms_only(name)) continue;  // refuses rods
    RodSystem rod = spiral(Mat3::Identity(), 0.002);
    const Vec3 g(1.0, -2.0, -9.81);
    rod.add_gravity(g);
    const Nodes start = rod.state().x;
    const auto integrator = make_integrator(name, exact_settings(1e-8));
    const double dt = 2e-4;
    for (int k = 0; k < 250; ++k) {
      rod.system->step(*integrator, dt);
      rod.carry_frames();
    }
    const Nodes moved = rod.state().x - start;
    const Vec3 fall = moved.leftCols(rod.points).rowwise().mean();
    double worst = 0.0;
    for (int i = 0; i < rod.points; ++i) worst = std::max(worst, (moved.col(i) - fall).norm());
    check("F39", "rod, deformation in free fall, " + name + ", m", worst, 0.0, 1e-10, Tolerance::kAbsolute);
    check("F39", "rod, spin in free fall, " + name + ", rad",
          moved.rightCols(rod.segments).cwiseAbs().maxCoeff() / rod.section.radius_of_gyration, 0.0, 1e-10,
          Tolerance::kAbsolute);
    // First order schemes: g t (t +- dt) / 2.
    check("F39", "rod, fall, " + name + ", m", fall.z(), 0.5 * g.z() * 0.05 * 0.05, 1.01 * dt / 0.05);
  }
}

TEST(RodNull, ARodAtRestStaysWhereItIs) {
  // F40: at rest without gravity nothing moves by 1e-12 m, in 1e4 steps (1e6 in the whole set).
  const int steps = verify_all() ? 1000000 : 10000;
  RodSystem rod = spiral(Mat3::Identity(), 1e-4);
  const Nodes start = rod.state().x;
  const auto integrator = make_integrator("symplectic_euler", {});
  const double dt = 0.3 / highest_frequency(rod.system->dynamics, rod.system->state);
  for (int k = 0; k < steps; ++k) {
    rod.system->step(*integrator, dt);
    rod.carry_frames();
  }
  check("F40", "rod, distance from rest after " + std::to_string(steps) + " steps, m",
        (rod.state().x - start).cwiseAbs().maxCoeff(), 0.0, 1e-12, Tolerance::kAbsolute);
}

TEST(RodNull, InternalDampingVanishesInRigidMotion) {
  // F41: v = c + omega x r, angles turning at omega . t: viscous force < 1e-14 of what a deformation of that speed
  // gets.
  RodSystem rod = spiral(Mat3::Identity(), 0.3);
  State s = rod.state();
  const Vec3 omega(0.3, -0.2, 0.5);
  for (int i = 0; i < rod.points; ++i) s.v.col(i) = Vec3(0.1, 0.2, -0.3) + omega.cross(Vec3(s.x.col(i)));
  for (int j = 0; j < rod.segments; ++j)
    s.v(0, rod.points + j) = omega.dot(s.tangents.col(j)) * rod.section.radius_of_gyration;
  const auto force = [&](const State& at) {
    Nodes f = Nodes::Zero(3, at.x.cols());
    for (const Energy* term : rod.system->dynamics.energies) term->add_force(at, &f);
    return f;
  };
  State still = s;
  still.v.setZero();
  State waving = s;
  waving.v.row(2) *= -1.0;
  const Nodes elastic = force(still);
  const double scale = (force(waving) - elastic).norm();
  EXPECT_GT(scale, 0.1);
  check("F41", "rod, viscous force in rigid motion over that in deformation", (force(s) - elastic).norm() / scale, 0.0,
        1e-14, Tolerance::kAbsolute);
}

TEST(RodNull, NoDirectionIsPreferred) {
  // F42: the turned scene moves like the scene, turned: 1e-6 after 0.1 s of large motion.
  const Mat3 r = Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const auto play = [](const Mat3& rotation) {
    RodSystem rod = spiral(rotation, 0.002);
    rod.add_gravity(rotation * Vec3(0, 0, -9.81));
    rod.clamp_start();
    rod.set_angle(kSegments - 1, 1.0);
    const auto integrator = make_integrator("symplectic_euler", exact_settings());
    for (int k = 0; k < 2000; ++k) {
      rod.system->step(*integrator, 5e-5);
      rod.carry_frames();
    }
    return Nodes(rotation.transpose() * rod.state().x.leftCols(rod.points));
  };
  const Nodes upright = play(Mat3::Identity()), turned = play(r);
  EXPECT_GT((upright.col(kSegments) - Vec3(0.1 * std::cos(6.0), 0.1 * std::sin(6.0), 0.24)).norm(), 0.01);
  check("F42", "rod, difference of turned motions, m", (upright - turned).cwiseAbs().maxCoeff(), 0.0, 1e-6,
        Tolerance::kAbsolute);
}

}  // namespace
}  // namespace deformable_sim::test
