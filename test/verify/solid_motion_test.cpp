// Volumes in motion: trajectories of an independent program, free fall, rigid motion, return from extreme states.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/rigid_copy.h"
#include "support/solids.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

TEST(GoldenBeam, IsReachedWithEveryLaw) {
  // 4 x 1 x 1 cubes of 5 cm cut alike, lumped masses, E = 2e4 Pa, nu = 0.3, rho = 1000 kg/m^3, clamped at x = 0,
  // released at rest under gravity: positions to the table's own error of 1e-11 m and that of RK4 at 0.15 ms, 1e-11 m.
  const std::vector<std::pair<std::string, SolidLaw>> tables = {{"hooke", SolidLaw::kHooke},
                                                                {"corot", SolidLaw::kCorotational},
                                                                {"stvk", SolidLaw::kStVenantKirchhoff},
                                                                {"nh", SolidLaw::kNeoHookean}};
  const double dt = 1.5e-4;
  for (const auto& [name, law] : tables) {
    TetMesh mesh = make_uniform_box(Vec3(0.2, 0.05, 0.05), {4, 1, 1});
    mesh.rest.colwise() += Vec3(0.1, 0.025, 0.025);
    System beam(mesh.rest, solid_masses(mesh, 1000.0));
    beam.add(make_solid(mesh, solid_material(law, 2e4, 0.3), 0.0, 0)).add_gravity();
    for (int i = 0; i < mesh.rest.cols(); ++i) {
      if (mesh.rest(0, i) < 1e-9) beam.hold(i);
    }
    const auto rk4 = make_integrator("rk4", {});
    double worst = 0.0, worst_speed = 0.0;
    int steps = 0;
    for (const TableRow& row : read_rows("F_golden_fem_beam_" + name + ".csv")) {
      for (; steps < std::lround(row("t") / dt); ++steps) beam.step(*rk4, dt);
      const int k = static_cast<int>(row("node"));  // the table counts z fastest, then y, then x
      const int node = k / 4 + 5 * (k / 2 % 2 + 2 * (k % 2));
      worst = std::max(worst, (beam.state.x.col(node) - Vec3(row("x"), row("y"), row("z"))).norm());
      worst_speed = std::max(worst_speed, (beam.state.v.col(node) - Vec3(row("vx"), row("vy"), row("vz"))).norm());
    }
    EXPECT_EQ(steps, 2000);
    check("E6", "beam, " + name + ": largest distance from the trajectory, m", worst, 0.0, 5e-11, Tolerance::kAbsolute);
    check("E6", "beam, " + name + ": largest difference of velocity, m/s", worst_speed, 0.0, 5e-9,
          Tolerance::kAbsolute);
  }
}

TEST(FreeFall, OfAVolumeIsThatOfAStone) {
  // z = z0 + v t - g t^2 / 2 for every node, by RK4 exactly, with internal forces and damping at work.
  for (const bool quadratic : {false, true}) {
    TetMesh mesh = make_irregular_box(Vec3(0.2, 0.2, 0.1), {2, 2, 1}, 2);
    if (quadratic) mesh = with_mid_nodes(mesh);
    for (const SolidLaw law : kSolidLaws) {
      System body(mesh.rest, solid_masses(mesh, 1000.0));
      body.add(make_solid(mesh, solid_material(law, 1e4, 0.4), 1e-3, 0)).add_gravity();
      body.state.v.row(0).setConstant(0.7);
      const auto rk4 = make_integrator("rk4", {});
      const int steps = 1000;
      for (int k = 0; k < steps; ++k) body.step(*rk4, 1e-3);
      const Nodes expected = mesh.rest.colwise() + Vec3(0.7, 0.0, -0.5 * kGravity);
      check("F39", name_of(law) + (quadratic ? ", quadratic" : ", linear") + ": largest deviation after 1 s, m",
            (body.state.x - expected).cwiseAbs().maxCoeff(), 0.0, 1e-10, Tolerance::kAbsolute);
    }
  }
}

TEST(RigidMotion, IsNotDamped) {
  // S_v = 0 for v = omega x x + t: at rest, and in a deformed state; |f| / (mu L^2) < 1e-14.
  std::mt19937 generator(3);
  for (const bool quadratic : {false, true}) {
    TetMesh mesh = make_irregular_box(Vec3(1, 1, 1), {2, 2, 2}, 2);
    if (quadratic) mesh = with_mid_nodes(mesh);
    for (const SolidLaw law : kSolidLaws) {
      const SolidMaterial material = solid_material(law, 2.6, 0.3);
      const auto damped = make_solid(mesh, material, 1.0, 0), free = make_solid(mesh, material, 0.0, 0);
      double worst = 0.0;
      for (const Vec3& s : {Vec3(1, 1, 1), Vec3(1.3, 1.1, 0.7)}) {
        State state;
        state.x = with_stretches(s, &generator) * mesh.rest;
        state.v = state.x;
        for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
          state.v.col(i) = Vec3(0.2, -0.4, 0.5).cross(state.x.col(i)) + Vec3(0.1, 0.3, -0.2);
        }
        Nodes difference = Nodes::Zero(3, state.x.cols()), elastic = difference;
        damped->add_force(state, &difference);
        free->add_force(state, &elastic);
        worst = std::max(worst, (difference - elastic).cwiseAbs().maxCoeff());
      }
      check("F41", name_of(law) + (quadratic ? ", quadratic" : ", linear") + ": largest damping force / (mu L^2)",
            worst, 0.0, 1e-14, Tolerance::kAbsolute);
    }
  }
}

/// Relaxes a cube of eight or more cells from `x`; the distance from its rest shape, turned and moved as it is.
double recovered(const TetMesh& mesh, SolidLaw law, const Nodes& x) {
  System body(x, solid_masses(mesh, 1.0));
  body.add(make_solid(mesh, solid_material(law, 2.6, 0.3), 0.0, 0));
  StaticSettings settings;
  settings.tolerance = 1e-10;
  settings.iterations = 500;
  settings.largest_move = 0.2;
  EXPECT_TRUE(find_equilibrium(&body, settings).converged) << name_of(law);
  return distance_from_rigid_copy(body.state.x, mesh.rest);
}

TEST(Recovery, FromCollapsedAndInvertedStatesIsComplete) {
  // F2-F5: nodes on a plane, a line, a point (with 1e-8 of noise), inside out, stretched, pressed flat: the laws that
  // are defined there come back to a rigid copy of the rest shape. A point is a stationary point of the stable
  // neo-Hookean energy, whose forces grow with the third power of the distance from it: it needs more noise.
  const TetMesh mesh = make_box(Vec3(1, 1, 1), {2, 2, 2});
  const Nodes noise = random_nodes(mesh.rest.cols(), 41);
  for (const SolidLaw law : {SolidLaw::kCorotational, SolidLaw::kStableNeoHookean}) {
    const std::vector<std::pair<std::string, Nodes>> states = {
        {"on a plane", Vec3(1, 1, 0).asDiagonal() * mesh.rest + 1e-8 * noise},
        {"on a line", Vec3(1, 0, 0).asDiagonal() * mesh.rest + 1e-8 * noise},
        {"on a point", (law == SolidLaw::kStableNeoHookean ? 1e-2 : 1e-8) * noise},
        {"inside out", Vec3(1, 1, -1).asDiagonal() * mesh.rest},
        {"ten times as long", Vec3(10, 1, 1).asDiagonal() * mesh.rest},
        {"a twentieth as long", Vec3(0.05, 1, 1).asDiagonal() * mesh.rest}};
    for (const auto& [name, x] : states) {
      check("F2-F5", name_of(law) + ", " + name + ": largest distance from the rest shape, m", recovered(mesh, law, x),
            0.0, 1e-4, Tolerance::kAbsolute);
    }
  }
}

TEST(Recovery, FromATangleIsTheRule) {
  // F1: all nodes at random in a cube. Besides the rest shape there are tangled equilibria, in which some elements are
  // inside out and held so by their neighbours: of ten tangles at least eight come back, with either law.
  const TetMesh mesh = make_box(Vec3(1, 1, 1), {3, 3, 3});
  for (const SolidLaw law : {SolidLaw::kCorotational, SolidLaw::kStableNeoHookean}) {
    const unsigned tangles = verify_all() ? 10 : 2;
    unsigned back = 0;
    for (unsigned seed = 0; seed < tangles; ++seed) {
      if (recovered(mesh, law, random_nodes(mesh.rest.cols(), seed)) < 1e-4) ++back;
    }
    check("F1", name_of(law) + ": share of random tangles that come back", static_cast<double>(back) / tangles, 1.0,
          0.2);
  }
}

TEST(Slivers, StayAtRest) {
  // F7: elements a thousand times as long as thick, at rest, under no force: nothing moves.
  TetMesh mesh = make_box(Vec3(1, 1, 1e-3), {1, 1, 1});
  for (const bool quadratic : {false, true}) {
    if (quadratic) mesh = with_mid_nodes(mesh);
    for (const SolidLaw law : kSolidLaws) {
      System body(mesh.rest, solid_masses(mesh, 1000.0));
      body.add(make_solid(mesh, solid_material(law, 1e5, 0.4), 1e-3, 0));
      const auto euler = make_integrator("implicit_euler", exact_settings(1e-6));
      for (int k = 0; k < 3; ++k) body.step(*euler, 1e-2);
      check("F7", name_of(law) + (quadratic ? ", quadratic" : ", linear") + ": largest speed, m/s",
            body.state.v.cwiseAbs().maxCoeff(), 0.0, 1e-9, Tolerance::kAbsolute);
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
