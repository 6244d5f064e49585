// The shear modulus of stiffness matrices, often off by a factor of two: section 0.2 of the yardsticks.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/element/solid_stress.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheets.h"
#include "support/solids.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kModulus = 2.6, kNu = 0.3;  // mu = 1

TEST(StiffnessMatrix, HasMuNotTwoMuOnItsShearRows) {
  // Simple shear x1 = X1 + gamma X2: s12 = mu gamma with the engineering angle gamma = 2 e12; Hooke's law at any angle,
  // the others in the limit of small ones (second order).
  for (const SolidLaw law : kSolidLaws) {
    const double gamma = law == SolidLaw::kHooke ? 0.3 : 1e-6;
    Mat3 f = Mat3::Identity();
    f(0, 1) = gamma;
    check("0.2", name_of(law) + ", s12 / (mu gamma) in simple shear",
          first_piola(solid_material(law, kModulus, kNu), f)(0, 1) / gamma, 1.0,
          law == SolidLaw::kHooke ? 1e-14 : 1e-9);
  }
}

TEST(StiffnessMatrix, IsTheSameInEveryDirection) {
  // Isotropy: psi(R^T F R) = psi(F); a shear row of 2 mu in place of mu breaks it. Turned by 45 degrees, to 1e-14.
  const Mat3 r = Eigen::AngleAxisd(M_PI / 4.0, Vec3::UnitZ()).toRotationMatrix();
  Mat3 f = Mat3::Identity();
  f(0, 0) = 1.2;
  f(1, 1) = 0.9;
  f(0, 1) = 0.05;
  for (const SolidLaw law : kSolidLaws) {
    const SolidMaterial material = solid_material(law, kModulus, kNu);
    check("0.2", name_of(law) + ", energy in directions turned by 45 degrees, relative",
          energy_density(material, r.transpose() * f * r) / energy_density(material, f), 1.0, 1e-14);
  }
}

TEST(SheetStiffness, IsTheSameInEveryDirection) {
  // The plane-stress matrix (C11, C12, C33 = E h / (2 (1 + nu))) of an isotropic sheet: W of a homogeneous strain, and
  // of the same strain turned by 45 degrees; shear alone stores G gamma^2 / 2 per area.
  const TriangleMesh mesh = make_grid(1.0, 1.0, 2, 2);
  for (const SolidLaw law : kSolidLaws) {
    System sheet(mesh.rest, triangle_masses(mesh, 1.0));
    sheet.add(make_membrane(mesh, isotropic_sheet(law, kModulus, kNu), 0));
    const auto energy = [&](const Mat3& f) {
      sheet.state.x = f * mesh.rest;
      return sheet.potential_energy();
    };
    const Mat3 r = Eigen::AngleAxisd(M_PI / 4.0, Vec3::UnitZ()).toRotationMatrix();
    Mat3 f = Mat3::Identity(), shear = Mat3::Identity();
    f(0, 0) = 1.2;
    f(1, 1) = 0.9;
    check("0.2", "sheet, " + name_of(law) + ", energy in directions turned by 45 degrees, relative",
          energy(r.transpose() * f * r) / energy(f), 1.0, 1e-13);
    const double gamma = 1e-4;
    shear(0, 1) = gamma;
    check("0.2", "sheet, " + name_of(law) + ", 2 W / gamma^2 in simple shear over G h",
          2.0 * energy(shear) / (gamma * gamma), 1.0, 1e-6);
  }
}

}  // namespace
}  // namespace deformable_sim::test
