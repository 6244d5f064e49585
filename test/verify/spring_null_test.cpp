// What springs must not do: F39 to F42, and the invariances of their forces.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "deformable_sim/core/energy/limit_springs.h"
#include "support/system.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

struct SpringBody {
  std::string name;
  Nodes rest;
  Eigen::VectorXd mass;
  SpringNetwork network;
};

/// One of every kind of network.
std::vector<SpringBody> spring_bodies(double damping_time) {
  std::vector<SpringBody> bodies;
  const Polyline line = make_line(1.0, 12);
  LineStiffness axial;
  axial.axial = 40.0;
  axial.damping_time = damping_time;
  bodies.push_back({"chain", line.rest, line_masses(line, 0.1), line_network(line, axial)});
  const Polyline ring = make_ring(1.0, 10);
  bodies.push_back({"loop", ring.rest, line_masses(ring, 0.1), line_network(ring, axial)});
  TriangleMesh grid = make_grid(0.5, 0.4, 5, 4);
  SheetStiffness sheet;
  sheet.membrane = 50.0;
  sheet.damping_time = damping_time;
  bodies.push_back({"grid", grid.rest, sheet_masses(grid, 0.15), sheet_network(grid, sheet)});
  ProvotStiffness provot;
  provot.structural = 40.0;
  provot.shear = 20.0;
  provot.flexion = 5.0;
  provot.damping_time = damping_time;
  bodies.push_back({"Provot sheet", grid.rest, sheet_masses(grid, 0.15), provot_network(grid, provot)});
  grid.rows = grid.cols = 0;
  bodies.push_back({"mesh", grid.rest, sheet_masses(grid, 0.15), sheet_network(grid, sheet)});
  const TetMesh box = make_box(Vec3(0.3, 0.2, 0.2), {3, 2, 2});
  const auto cells = lattice_cells(box, Vec3(0.1, 0.1, 0.1));
  LatticeStiffness lattice;
  lattice.neighbours = LatticeNeighbours::kBodies;
  lattice.youngs_modulus = 2e3;
  lattice.damping_time = damping_time;
  bodies.push_back(
      {"lattice", box.rest, lattice_masses(box.rest, cells, 300.0), lattice_network(box.rest, cells, lattice)});
  return bodies;
}

Nodes random_nodes(Eigen::Index n, double scale, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, scale);
  return Nodes::NullaryExpr(3, n, [&] { return normal(generator); });
}

Mat3 random_rotation(unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(generator), normal(generator), normal(generator), normal(generator))
      .normalized()
      .toRotationMatrix();
}

TEST(EverySpringBody, FallsAsOnePoint) {
  // F39: x = x0 - g t^2 / 2 to 1e-10 m, no node differs: rk4 is exact for a constant acceleration.
  for (const SpringBody& b : spring_bodies(2e-3)) {
    System body(b.rest, b.mass);
    body.add_springs(b.network).add_gravity();
    const auto integrator = make_integrator("rk4", {});
    for (int k = 0; k < 400; ++k) body.step(*integrator, 5e-4);
    Nodes expected = b.rest;
    expected.row(2).array() -= 0.5 * kGravity * 0.2 * 0.2;
    check("F39", b.name + ", distance from free fall after 0.2 s, m", (body.state.x - expected).cwiseAbs().maxCoeff(),
          0.0, 1e-10, Tolerance::kAbsolute);
  }
}

TEST(EverySpringBody, RestsWhereItIs) {
  // F40: at rest without gravity nothing moves by 1e-12 m, in 1e4 steps (1e6 in the whole set).
  const int steps = verify_all() ? 1000000 : 10000;
  for (const SpringBody& b : spring_bodies(2e-3)) {
    System body(b.rest, b.mass);
    body.add_springs(b.network);
    const auto integrator = make_integrator("symplectic_euler", {});
    const double dt = 0.5 / highest_frequency(body.dynamics, body.state);
    for (int k = 0; k < steps; ++k) body.step(*integrator, dt);
    check("F40", b.name + ", distance from rest after " + std::to_string(steps) + " steps, m",
          (body.state.x - b.rest).cwiseAbs().maxCoeff(), 0.0, 1e-12, Tolerance::kAbsolute);
  }
}

TEST(EverySpringBody, FeelsNoDampingInRigidMotion) {
  // F41: v = w x r + v0 at a turned rest shape: the viscous force vanishes against that of a deformation as fast.
  for (const SpringBody& b : spring_bodies(0.1)) {
    System body(random_rotation(4) * b.rest, b.mass);
    body.add_springs(b.network);
    const auto viscous = [&](const Nodes& v) {
      body.state.v.setZero();
      const Nodes elastic = body.forces();
      body.state.v = v;
      return (body.forces() - elastic).norm();
    };
    Nodes rigid(3, b.rest.cols());
    for (Eigen::Index i = 0; i < rigid.cols(); ++i)
      rigid.col(i) = Vec3(0.3, -2.0, 1.0).cross(Vec3(body.state.x.col(i))) + Vec3(1, 2, -1);
    Nodes stretching = body.state.x;
    stretching *= rigid.norm() / stretching.norm();
    check("F41", b.name + ", viscous force in rigid motion over that in stretching",
          viscous(rigid) / viscous(stretching), 0.0, 1e-14, Tolerance::kAbsolute);
  }
}

TEST(EverySpringBody, MovesTheSameInATurnedFrame) {
  // F42: R x(t) for a turned start. Forces to rounding; a motion to 1e-6 of its size (rounding grows with time).
  for (const SpringBody& b : spring_bodies(1e-3)) {
    const Mat3 r = random_rotation(9);
    System upright(b.rest + random_nodes(b.rest.cols(), 0.01, 1), b.mass);
    upright.add_springs(b.network);
    upright.state.v = random_nodes(b.rest.cols(), 0.3, 2);
    System turned(r * upright.state.x, b.mass);
    turned.add_springs(b.network);
    turned.state.v = r * upright.state.v;
    const Nodes f = upright.forces();
    check("F42", b.name + ", forces turned, relative", (turned.forces() - r * f).norm() / f.norm(), 0.0, 1e-12,
          Tolerance::kAbsolute);
    check("F42", b.name + ", energy turned, relative", turned.potential_energy() / upright.potential_energy(), 1.0,
          1e-12);
    const auto integrator = make_integrator("symplectic_euler", {});
    const double dt = 0.3 / highest_frequency(upright.dynamics, upright.state);
    for (int k = 0; k < 500; ++k) {
      upright.step(*integrator, dt);
      turned.step(*integrator, dt);
    }
    check("F42", b.name + ", motion turned, m", (turned.state.x - r * upright.state.x).cwiseAbs().maxCoeff(), 0.0, 1e-6,
          Tolerance::kAbsolute);
  }
}

/// Sum of f and of x cross f, over the sums of their sizes.
void check_momenta(const std::string& name, const Nodes& x, const Nodes& f) {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double force_size = 0.0, torque_size = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const Vec3 moment = Vec3(x.col(i)).cross(Vec3(f.col(i)));
    force += f.col(i);
    torque += moment;
    force_size += f.col(i).norm();
    torque_size += moment.norm();
  }
  check("momentum", name + ", sum of internal forces, relative", force.norm() / force_size, 0.0, 1e-12,
        Tolerance::kAbsolute);
  check("momentum", name + ", sum of their moments, relative", torque.norm() / torque_size, 0.0, 1e-12,
        Tolerance::kAbsolute);
}

TEST(EverySpringBody, ExertsNoForceOnItself) {
  // sum f = 0 and sum x x f = 0 in any state of deformation and motion, damping included.
  for (const SpringBody& b : spring_bodies(0.05)) {
    for (const double disorder : {0.01, 1.0}) {
      System body(b.rest + random_nodes(b.rest.cols(), disorder, 5), b.mass);
      body.add_springs(b.network);
      body.state.v = random_nodes(b.rest.cols(), 2.0, 6);
      check_momenta(b.name + ", disorder " + std::to_string(disorder) + " m", body.state.x, body.forces());
    }
  }
}

TEST(StrainLimits, ExertNoForceOnTheBodyEither) {
  const Nodes x = random_nodes(6, 0.3, 8);
  const LimitSprings limits(
      {{0, 1, 0.05, 30.0, 2.0}, {1, 2, 0.1, 40.0, 0.0}, {3, 4, 0.1, 10.0, 5.0}, {5, 0, 0.2, 20.0, 1.0}});
  State s;
  s.x = x;
  s.v = Nodes::Zero(3, 6);
  Nodes f = Nodes::Zero(3, 6);
  limits.add_force(s, &f);
  check_momenta("strain limits", x, f);
  State turned = s;
  const Mat3 r = random_rotation(3);
  turned.x = r * s.x;
  Nodes g = Nodes::Zero(3, 6);
  limits.add_force(turned, &g);
  check("F42", "strain limits, forces turned, relative", (g - r * f).norm() / f.norm(), 0.0, 1e-12,
        Tolerance::kAbsolute);
}

}  // namespace
}  // namespace deformable_sim::test
