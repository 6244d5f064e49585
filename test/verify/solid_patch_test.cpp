// Volumes of irregular elements under uniform strain: patch tests, and the material a testing machine would measure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/element/solid_stress.h"
#include "support/solids.h"
#include "support/statics.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

const Vec3 kSize(1.0, 0.8, 0.6);

TetMesh specimen(bool quadratic) {
  const TetMesh mesh = make_irregular_box(kSize, {3, 3, 3}, 21);
  return quadratic ? with_mid_nodes(mesh) : mesh;
}

std::string label(SolidLaw law, bool quadratic) {
  return name_of(law) + (quadratic ? ", quadratic" : ", linear");
}

TEST(Patch, OfIrregularTetrahedraIsUniformUnderUniformStrain) {
  // x = F X on the boundary: x = F X inside to 1e-10, P the same in all elements to 1e-8, for every law [Irons 1972].
  std::mt19937 generator(31);
  const Mat3 f = with_stretches(Vec3(1.2, 1.05, 0.9), &generator);
  for (const SolidLaw law : kSolidLaws) {
    for (const bool quadratic : {false, true}) {
      const TetMesh mesh = specimen(quadratic);
      const SolidMaterial material = solid_material(law, 2.6, 0.3);
      System body(f * mesh.rest, solid_masses(mesh, 1.0));
      std::uniform_real_distribution<double> uniform(-0.01, 0.01);
      for (int i = 0; i < mesh.rest.cols(); ++i) {
        if (on_surface(kSize, mesh.rest.col(i))) {
          body.hold(i);
        } else {
          body.state.x.col(i) += Vec3(uniform(generator), uniform(generator), uniform(generator));
        }
      }
      ASSERT_LT(body.dynamics.kinematics.node.size(), static_cast<size_t>(mesh.rest.cols()));
      body.add(make_solid(mesh, material, 0.0, 0));
      StaticSettings settings;
      settings.tolerance = 1e-14;
      const Equilibrium equilibrium = find_equilibrium(&body, settings);
      EXPECT_TRUE(equilibrium.converged) << label(law, quadratic) << " " << equilibrium.residual;
      check("patch", label(law, quadratic) + ": largest distance from F X, m",
            (body.state.x - f * mesh.rest).cwiseAbs().maxCoeff(), 0.0, 1e-10, Tolerance::kAbsolute);
      const Mat3 stress = first_piola(material, f);
      double worst = 0.0;
      for (const Mat3& gradient : deformation_gradients(mesh, body.state.x)) {
        worst = std::max(worst, (first_piola(material, gradient) - stress).cwiseAbs().maxCoeff() / material.mu);
      }
      check("patch", label(law, quadratic) + ": largest deviation of P/mu", worst, 0.0, 1e-8, Tolerance::kAbsolute);
    }
  }
}

/// What a machine measures: a specimen between two plates that move along x and let it slide.
struct Traction {
  double force;    // N, on the plate at the far end
  double lateral;  // mean stretch along y
};

Traction pull(const TetMesh& mesh, const SolidMaterial& material, double strain) {
  System body(Vec3(1.0 + strain, 1.0, 1.0).asDiagonal() * mesh.rest, solid_masses(mesh, 1.0));
  body.add(make_solid(mesh, material, 0.0, 0));
  StaticSettings settings;
  settings.tolerance = 1e-14;
  const Vec3 half = 0.5 * kSize;
  std::vector<int> far_end;
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    const Vec3 p = mesh.rest.col(i);
    if (std::abs(std::abs(p.x()) - half.x()) < 1e-9) settings.rollers.push_back({i, 0});
    if (std::abs(p.x() - half.x()) < 1e-9) far_end.push_back(i);
    if (std::abs(p.y() + half.y()) < 1e-9) settings.rollers.push_back({i, 1});
    if (std::abs(p.z() + half.z()) < 1e-9) settings.rollers.push_back({i, 2});
  }
  EXPECT_TRUE(find_equilibrium(&body, settings).converged);
  Traction result{0.0, 0.0};
  const Nodes f = body.forces();
  for (const int i : far_end) result.force -= f(0, i);
  result.lateral = (body.state.x.row(1).maxCoeff() - body.state.x.row(1).minCoeff()) / kSize.y();
  return result;
}

/// Mean first Piola-Kirchhoff stress of a specimen whose surface is moved to F X.
Mat3 mean_stress(const TetMesh& mesh, const SolidMaterial& material, const Mat3& f) {
  System body(f * mesh.rest, solid_masses(mesh, 1.0));
  body.add(make_solid(mesh, material, 0.0, 0));
  for (int i = 0; i < mesh.rest.cols(); ++i) {
    if (on_surface(kSize, mesh.rest.col(i))) body.hold(i);
  }
  StaticSettings settings;
  settings.tolerance = 1e-14;
  EXPECT_TRUE(find_equilibrium(&body, settings).converged);
  // V mean(P) = sum over the surface of (force on the body) X^T.
  return -body.forces() * mesh.rest.transpose() / kSize.prod();
}

TEST(TestingMachine, GetsTheMaterialBackThatWasPutIn) {
  // E = dP/de, nu = -d(lateral)/de in traction, G = dP12/dgamma in shear, B = dp/dV in compression, at strains of
  // +-1e-5: the mean of both is affected by 1e-10 only.
  const double youngs_modulus = 2.6, poissons_ratio = 0.35, strain = 1e-5;
  for (const SolidLaw law : kSolidLaws) {
    const SolidMaterial material = solid_material(law, youngs_modulus, poissons_ratio);
    for (const bool quadratic : {false, true}) {
      const TetMesh mesh = specimen(quadratic);
      const Traction more = pull(mesh, material, strain), less = pull(mesh, material, -strain);
      const double area = kSize.y() * kSize.z();
      check("C2", label(law, quadratic) + ": Young's modulus, Pa", (more.force - less.force) / (2.0 * strain * area),
            youngs_modulus, 1e-8);
      check("C2", label(law, quadratic) + ": Poisson's ratio", -(more.lateral - less.lateral) / (2.0 * strain),
            poissons_ratio, 1e-8);
      Mat3 shear = Mat3::Zero();
      shear(0, 1) = strain;
      const Mat3 sheared =
          mean_stress(mesh, material, Mat3::Identity() + shear) - mean_stress(mesh, material, Mat3::Identity() - shear);
      check("C2", label(law, quadratic) + ": shear modulus, Pa", sheared(0, 1) / (2.0 * strain),
            youngs_modulus / (2.0 * (1.0 + poissons_ratio)), 1e-8);
      const Mat3 swollen = mean_stress(mesh, material, (1.0 + strain) * Mat3::Identity()) -
                           mean_stress(mesh, material, (1.0 - strain) * Mat3::Identity());
      check("C2", label(law, quadratic) + ": bulk modulus, Pa", swollen.trace() / (3.0 * 6.0 * strain),
            youngs_modulus / (3.0 * (1.0 - 2.0 * poissons_ratio)), 1e-8);
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
