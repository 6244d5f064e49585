// Stretch and bending of sheets: derivatives, conservation, invariance, at states a simulation may meet.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/error.h"
#include "support/derivative_harness.h"
#include "support/sheet_meshes.h"

namespace deformable_sim::test {
namespace {

struct Term {
  std::string name;
  bool turns;  // the energy does not change with a rotation of the whole
  std::function<std::unique_ptr<Energy>(const TriangleMesh&)> make;
};

SheetMaterial woven(SolidLaw law, double damping) {
  SheetMaterial material;
  material.law = law;
  material.warp = 300.0;
  material.weft = 120.0;
  material.poissons_ratio = 0.35;
  material.shear = 25.0;
  material.damping = damping;
  material.warp_direction = Vec3(0.8, 0.6, 0.0);
  return material;
}

BendingMaterial stiff_along_warp(double damping) {
  BendingMaterial material;
  material.warp = 3.0;
  material.weft = 1.2;
  material.poissons_ratio = 0.25;
  material.damping = damping;
  material.warp_direction = Vec3(0.8, 0.6, 0.0);
  return material;
}

std::vector<Term> terms() {
  std::vector<Term> all;
  for (const SolidLaw law : {SolidLaw::kCorotational, SolidLaw::kNeoHookean, SolidLaw::kStableNeoHookean,
                             SolidLaw::kMooneyRivlin, SolidLaw::kStVenantKirchhoff, SolidLaw::kHooke}) {
    for (const double damping : {0.0, 0.03}) {
      const std::string name = "law " + std::to_string(static_cast<int>(law)) + (damping > 0 ? " damped" : "");
      all.push_back({name, law != SolidLaw::kHooke, [law, damping](const TriangleMesh& mesh) {
                       SheetMaterial material = isotropic_sheet(law, 200.0, 0.3);
                       material.damping = damping;
                       return make_membrane(mesh, material, 0);
                     }});
    }
  }
  for (const double damping : {0.0, 0.03}) {
    const std::string how = damping > 0 ? " damped" : "";
    all.push_back({"orthotropic" + how, true, [damping](const TriangleMesh& mesh) {
                     return make_membrane(mesh, woven(SolidLaw::kStVenantKirchhoff, damping), 0);
                   }});
    all.push_back({"hinges" + how, true,
                   [damping](const TriangleMesh& mesh) { return make_bending(mesh, stiff_along_warp(damping), 0); }});
    all.push_back({"creased hinges" + how, true, [damping](const TriangleMesh& mesh) {
                     BendingMaterial material = stiff_along_warp(damping);
                     material.rest = BendingMaterial::Rest::kAsMeshed;
                     material.creases.push_back({mesh.triangles[0][0], mesh.triangles[0][2], 0.9});
                     return make_bending(mesh, material, 0);
                   }});
    all.push_back({"quadratic" + how, true, [damping](const TriangleMesh& mesh) {
                     return make_quadratic_bending(mesh, stiff_along_warp(damping), 0);
                   }});
  }
  return all;
}

/// Four nodes by three, the diagonal of the first cell inside.
TriangleMesh small_mesh() {
  TriangleMesh mesh = uniform_grid(1.2, 0.8, 3, 2);
  mesh.rest.col(5) += Vec3(0.07, -0.05, 0.0);
  mesh.rest.col(6) += Vec3(-0.04, 0.09, 0.0);
  return mesh;
}

Mat3 some_rotation() {
  return Eigen::AngleAxisd(2.1, Vec3(0.3, -0.8, 0.5).normalized()).toRotationMatrix();
}

std::vector<std::pair<std::string, State>> states(const TriangleMesh& mesh) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  const Eigen::Index n = mesh.rest.cols();
  const auto noise = [&](double size) {
    return Nodes(Nodes::NullaryExpr(3, n, [&] { return size * normal(generator); }));
  };
  std::vector<std::pair<std::string, State>> all;
  const auto add = [&](const std::string& name, const Nodes& x) {
    State s;
    s.x = x;
    s.v = noise(1.0);
    all.emplace_back(name, s);
  };
  add("near rest", mesh.rest + noise(0.01));
  add("random", mesh.rest + noise(0.12));
  add("stretched", Vec3(1.8, 1.5, 1.0).asDiagonal() * (mesh.rest + noise(0.03)));
  add("compressed", Vec3(0.5, 0.7, 1.0).asDiagonal() * (mesh.rest + noise(0.03)));
  add("rotated", (some_rotation() * (mesh.rest + noise(0.05))).colwise() + Vec3(3, -2, 1));
  // Folded to 170 degrees along a column of nodes.
  Nodes folded = mesh.rest + noise(0.003);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double beyond = folded(0, i) - 0.2;
    if (beyond > 0.0) folded.col(i) += beyond * Vec3(std::cos(2.967) - 1.0, 0.0, std::sin(2.967));
  }
  add("folded", folded);
  // A triangle flattened to a hundredth of its height.
  Nodes thin = mesh.rest + noise(0.02);
  const auto& t = mesh.triangles[2];
  thin.col(t[2]) = 0.6 * thin.col(t[0]) + 0.4 * thin.col(t[1]) + 0.01 * (thin.col(t[2]) - thin.col(t[0]));
  add("nearly degenerate", thin);
  return all;
}

TEST(SheetTerm, HasTheDerivativesItDelivers) {
  // f = -dE/dx and A = -(dx df/dx + dv df/dv) by central differences; projected ones positive semi-definite.
  const TriangleMesh mesh = small_mesh();
  for (const Term& term : terms()) {
    const auto energy = term.make(mesh);
    for (const auto& [name, state] : states(mesh)) {
      SCOPED_TRACE(term.name + ", " + name);
      check_derivatives(energy.get(), state, true);
    }
  }
}

TEST(SheetTerm, GivesNoMomentumAndNoAngularMomentum) {
  // sum f = 0; sum x cross f = 0 for all that do not notice a rotation of the whole.
  const TriangleMesh mesh = small_mesh();
  for (const Term& term : terms()) {
    const auto energy = term.make(mesh);
    for (const auto& [name, state] : states(mesh)) {
      SCOPED_TRACE(term.name + ", " + name);
      const Nodes f = force_of(*energy, state);
      Vec3 torque = Vec3::Zero();
      for (Eigen::Index i = 0; i < f.cols(); ++i) torque += Vec3(state.x.col(i)).cross(Vec3(f.col(i)));
      const double scale = f.colwise().norm().sum() + 1e-12;
      EXPECT_LT(f.rowwise().sum().norm(), 1e-12 * scale);
      if (!term.turns) continue;
      EXPECT_LT(torque.norm(), 1e-12 * scale * (1.0 + state.x.colwise().norm().maxCoeff()));
    }
  }
}

TEST(SheetTerm, TurnsWithTheSheet) {
  // E(R x + t) = E(x), f(R x + t, R v) = R f(x, v).
  const TriangleMesh mesh = small_mesh();
  const Mat3 r = some_rotation();
  for (const Term& term : terms()) {
    if (!term.turns) continue;
    const auto energy = term.make(mesh);
    for (const auto& [name, state] : states(mesh)) {
      SCOPED_TRACE(term.name + ", " + name);
      State turned = state;
      turned.x = (r * state.x).colwise() + Vec3(0.5, 1.5, -1.0);
      turned.v = r * state.v;
      const double value = energy->value(state);
      EXPECT_NEAR(energy->value(turned), value, 1e-12 * (1.0 + value));
      const Nodes f = force_of(*energy, state);
      EXPECT_LT((force_of(*energy, turned) - r * f).norm(), 1e-11 * (f.norm() + 1.0));
    }
  }
}

TEST(SheetTerm, DoesNotDampRigidMotion) {
  // v = u + omega x x: the rate of the Green strain and of all angles is zero, so is the viscous force.
  const TriangleMesh mesh = small_mesh();
  for (const Term& term : terms()) {
    const auto energy = term.make(mesh);
    for (auto& [name, state] : states(mesh)) {
      SCOPED_TRACE(term.name + ", " + name);
      State still = state, moving = state;
      still.v.setZero();
      for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
        moving.v.col(i) = Vec3(0.3, 0.1, -0.2) + Vec3(0.7, -0.4, 0.9).cross(Vec3(state.x.col(i)));
      }
      const Nodes f = force_of(*energy, still);
      const double scale = 1.0 + force_of(*energy, state).norm();
      EXPECT_LT((force_of(*energy, moving) - f).norm(), 1e-12 * scale);
    }
  }
}

TEST(SheetTerm, RestsInItsRestShape) {
  // x = R rest + t: no energy, no force.
  const TriangleMesh mesh = small_mesh();
  State s;
  s.x = (some_rotation() * mesh.rest).colwise() + Vec3(1, 2, 3);
  s.v = Nodes::Zero(3, mesh.rest.cols());
  for (const Term& term : terms()) {
    if (!term.turns || term.name.find("creased") != std::string::npos) continue;
    SCOPED_TRACE(term.name);
    const auto energy = term.make(mesh);
    EXPECT_LT(std::abs(energy->value(s)), 1e-12);
    EXPECT_LT(force_of(*energy, s).norm(), 1e-11);
  }
}

}  // namespace
}  // namespace deformable_sim::test
