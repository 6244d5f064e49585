// What sheets and volumes as continua must not do: fall apart, creep, be damped in rigid motion, prefer a direction.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/solids.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

using Terms = std::vector<std::unique_ptr<Energy>>;

/// A body by its rest shape: `terms` makes its energies, with damping (s) of the strain rate.
struct Continuum {
  std::string name;
  Nodes rest;
  Eigen::VectorXd mass;
  std::function<Terms(double damping)> terms;
};

Continuum sheet(const std::string& name, const SheetMaterial& membrane, bool quadratic) {
  const TriangleMesh mesh = irregular_mesh(0.3, 0.2, 4, 3, 0.2);
  const auto terms = [mesh, membrane, quadratic](double damping) {
    SheetMaterial in_plane = membrane;
    in_plane.damping = damping;
    BendingMaterial bending = isotropic_bending(1e-3, 0.3);
    bending.damping = damping;
    Terms made;
    made.push_back(make_membrane(mesh, in_plane, 0));
    made.push_back(quadratic ? make_quadratic_bending(mesh, bending, 0) : make_bending(mesh, bending, 0));
    return made;
  };
  return {name, mesh.rest, triangle_masses(mesh, 0.2), terms};
}

Continuum solid(const std::string& name, SolidLaw law, bool quadratic) {
  TetMesh mesh = make_irregular_box(Vec3(0.2, 0.1, 0.1), {2, 1, 1}, 2);
  if (quadratic) mesh = with_mid_nodes(mesh);
  const auto terms = [mesh, law](double damping) {
    Terms made;
    made.push_back(make_solid(mesh, solid_material(law, 1e4, 0.4), damping, 0));
    return made;
  };
  return {name, mesh.rest, solid_masses(mesh, 1000.0), terms};
}

std::vector<Continuum> continua() {
  SheetMaterial woven;
  woven.warp = 300.0;
  woven.weft = 120.0;
  woven.poissons_ratio = 0.35;
  woven.shear = 25.0;
  woven.warp_direction = Vec3(std::cos(0.4), std::sin(0.4), 0.0);
  return {sheet("membrane and hinges", isotropic_sheet(SolidLaw::kStableNeoHookean, 200.0, 0.3), false),
          sheet("woven membrane, quadratic bending", woven, true),
          solid("tetrahedra, corotational", SolidLaw::kCorotational, false),
          solid("quadratic tetrahedra, neo-Hookean", SolidLaw::kNeoHookean, true)};
}

std::unique_ptr<System> make_body(const Continuum& c, const Nodes& x, double damping) {
  auto body = std::make_unique<System>(x, c.mass);
  for (auto& term : c.terms(damping)) body->add(std::move(term));
  return body;
}

Nodes random_nodes(Eigen::Index n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0.0, size);
  return Nodes::NullaryExpr(3, n, [&] { return normal(generator); });
}

Mat3 some_rotation() {
  return Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
}

TEST(EveryContinuum, FallsAsOnePoint) {
  // F39: x = x0 - g t^2 / 2 to 1e-10 m in a turned frame, with damping at work: rk4 is exact for constant acceleration.
  for (const Continuum& c : continua()) {
    const Nodes start = some_rotation() * c.rest;
    const auto body = make_body(c, start, 1e-4);
    body->add_gravity();
    const auto integrator = make_integrator("rk4", {});
    const double dt = 0.5 / highest_frequency(body->dynamics, body->state);
    const int steps = static_cast<int>(std::ceil(0.2 / dt));
    for (int k = 0; k < steps; ++k) body->step(*integrator, 0.2 / steps);
    Nodes expected = start;
    expected.row(2).array() -= 0.5 * kGravity * 0.2 * 0.2;
    check("F39", c.name + ", distance from free fall after 0.2 s, m", (body->state.x - expected).cwiseAbs().maxCoeff(),
          0.0, 1e-10, Tolerance::kAbsolute);
  }
}

TEST(EveryContinuum, RestsWhereItIs) {
  // F40: at rest without gravity nothing moves by 1e-12 m, in 1e4 steps (1e6 in the whole set).
  const int steps = verify_all() ? 1000000 : 10000;
  for (const Continuum& c : continua()) {
    const auto body = make_body(c, c.rest, 1e-4);
    const auto integrator = make_integrator("symplectic_euler", {});
    const double dt = 0.3 / highest_frequency(body->dynamics, body->state);
    for (int k = 0; k < steps; ++k) body->step(*integrator, dt);
    check("F40", c.name + ", distance from rest after " + std::to_string(steps) + " steps, m",
          (body->state.x - c.rest).cwiseAbs().maxCoeff(), 0.0, 1e-12, Tolerance::kAbsolute);
  }
}

TEST(EveryContinuum, FeelsNoDampingInRigidMotion) {
  // F41: v = w x r + v0 at a turned rest shape: the viscous force vanishes against that of a deformation as fast.
  for (const Continuum& c : continua()) {
    const auto body = make_body(c, some_rotation() * c.rest, 0.1);
    const auto viscous = [&](const Nodes& v) {
      body->state.v.setZero();
      const Nodes elastic = body->forces();
      body->state.v = v;
      return (body->forces() - elastic).norm();
    };
    Nodes rigid(3, c.rest.cols());
    for (Eigen::Index i = 0; i < rigid.cols(); ++i) {
      rigid.col(i) = Vec3(0.3, -2.0, 1.0).cross(Vec3(body->state.x.col(i))) + Vec3(1, 2, -1);
    }
    Nodes stretching = body->state.x;
    stretching *= rigid.norm() / stretching.norm();
    check("F41", c.name + ", viscous force in rigid motion over that in stretching",
          viscous(rigid) / viscous(stretching), 0.0, 1e-14, Tolerance::kAbsolute);
  }
}

TEST(EveryContinuum, MovesTheSameInATurnedFrame) {
  // F42: R x(t) for a turned start. Forces to rounding, 1e-12; a motion to 1e-6 m (rounding grows with time).
  for (const Continuum& c : continua()) {
    const Mat3 r = some_rotation();
    const auto upright = make_body(c, c.rest + random_nodes(c.rest.cols(), 0.004, 1), 1e-3);
    upright->state.v = random_nodes(c.rest.cols(), 0.1, 2);
    const auto turned = make_body(c, r * upright->state.x, 1e-3);
    turned->state.v = r * upright->state.v;
    const Nodes f = upright->forces();
    check("F42", c.name + ", forces turned, relative", (turned->forces() - r * f).norm() / f.norm(), 0.0, 1e-12,
          Tolerance::kAbsolute);
    check("F42", c.name + ", energy turned, relative", turned->potential_energy() / upright->potential_energy(), 1.0,
          1e-12);
    const auto integrator = make_integrator("implicit_midpoint", {});
    for (int k = 0; k < 50; ++k) {
      upright->step(*integrator, 1e-3);
      turned->step(*integrator, 1e-3);
    }
    EXPECT_GT((upright->state.x - c.rest).cwiseAbs().maxCoeff(), 1e-3) << c.name;
    check("F42", c.name + ", motion turned, m", (turned->state.x - r * upright->state.x).cwiseAbs().maxCoeff(), 0.0,
          1e-6, Tolerance::kAbsolute);
  }
}

}  // namespace
}  // namespace deformable_sim::test
