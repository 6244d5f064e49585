// Membrane triangles against closed forms: patch test, traction, shear, biaxial, finite stretch, vibration.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kMembrane = 200.0, kNu = 0.3;  // N/m

const std::vector<std::pair<std::string, SolidLaw>>& laws() {
  static const std::vector<std::pair<std::string, SolidLaw>> all = {
      {"hooke", SolidLaw::kHooke},
      {"corotational", SolidLaw::kCorotational},
      {"st_venant_kirchhoff", SolidLaw::kStVenantKirchhoff},
      {"neo_hookean", SolidLaw::kNeoHookean},
      {"stable_neo_hookean", SolidLaw::kStableNeoHookean},
      {"mooney_rivlin", SolidLaw::kMooneyRivlin}};
  return all;
}

/// Warp 300 N/m, weft 120 N/m, turned by `angle` (rad) from x.
SheetMaterial woven(double angle) {
  SheetMaterial material;
  material.warp = 300.0;
  material.weft = 120.0;
  material.poissons_ratio = 0.35;
  material.shear = 25.0;
  material.warp_direction = Vec3(std::cos(angle), std::sin(angle), 0.0);
  return material;
}

std::vector<std::pair<std::string, SheetMaterial>> materials() {
  std::vector<std::pair<std::string, SheetMaterial>> all;
  for (const auto& [name, law] : laws()) all.emplace_back(name, isotropic_sheet(law, kMembrane, kNu));
  all.emplace_back("orthotropic", woven(0.4));
  return all;
}

/// A sheet in the x-y plane whose nodes stay in it.
struct FlatSheet {
  FlatSheet(const TriangleMesh& rest, const SheetMaterial& material)
      : mesh(rest), system(mesh.rest, Eigen::VectorXd::Ones(mesh.rest.cols())) {
    system.add(make_membrane(mesh, material, 0));
    for (int i = 0; i < mesh.rest.cols(); ++i) settings.rollers.push_back({i, 2});
    settings.tolerance = 1e-12 * kMembrane;
  }
  void hold_border(const Eigen::Matrix2d& gradient) {
    for (int i = 0; i < mesh.rest.cols(); ++i) {
      system.state.x.col(i).head<2>() = gradient * mesh.rest.col(i).head<2>();
      if (on_border(mesh, i)) system.hold(i);
      // Away from the solution: the solver has to find it.
      if (!on_border(mesh, i)) system.state.x.col(i).head<2>() += Eigen::Vector2d(0.01, -0.013);
    }
  }

  TriangleMesh mesh;
  System system;
  StaticSettings settings;
};

TEST(MembranePatch, StaysAffineInsideAnAffineBorder) {
  // Irons' patch test: x = G X on the border of an irregular mesh gives x = G X inside.
  const Eigen::Matrix2d gradient = (Eigen::Matrix2d() << 1.12, 0.07, -0.05, 0.93).finished();
  for (const auto& [name, material] : materials()) {
    FlatSheet sheet(irregular_mesh(1.0, 0.8, 6, 5, 0.3), material);
    sheet.hold_border(gradient);
    ASSERT_TRUE(find_equilibrium(&sheet.system, sheet.settings).converged) << name;
    const Nodes& x = sheet.system.state.x;
    double off = 0.0;
    for (int i = 0; i < x.cols(); ++i) {
      off = std::max(off, (x.col(i).head<2>() - gradient * sheet.mesh.rest.col(i).head<2>()).norm());
    }
    check("C2", "membrane patch test, " + name + ", largest distance from affine, m", off, 0.0, 1e-10,
          Tolerance::kAbsolute);
    // Uniform strain: the singular values of G at every node.
    const Eigen::Matrix2Xf strain = principal_strains(sheet.mesh, x);
    const Eigen::Vector2d expected = gradient.jacobiSvd().singularValues().array() - 1.0;
    EXPECT_LT((strain.cast<double>().colwise() - expected).cwiseAbs().maxCoeff(), 1e-6);
  }
}

/// Pulled along x to `stretch`, the sides free: nominal stress (N/m) and the stretch across.
struct Traction {
  double stress, across;
};

Traction pull(const SheetMaterial& material, double stretch) {
  FlatSheet sheet(irregular_mesh(1.0, 0.8, 5, 4, 0.25), material);
  Nodes& x = sheet.system.state.x;
  x.row(0) *= stretch;
  sheet.settings.rollers.push_back({0, 1});
  for (int i = 0; i < x.cols(); ++i) {
    const double along = sheet.mesh.rest(0, i);
    if (along < 1e-9 || along > 1.0 - 1e-9) sheet.settings.rollers.push_back({i, 0});
  }
  EXPECT_TRUE(find_equilibrium(&sheet.system, sheet.settings).converged);
  double force = 0.0;
  const Nodes f = sheet.system.forces();
  for (int i = 0; i < x.cols(); ++i) {
    if (sheet.mesh.rest(0, i) > 1.0 - 1e-9) force -= f(0, i);
  }
  // The two corners at x = 0 lie 0.8 m apart at rest.
  double low = 1e9, high = -1e9;
  for (int i = 0; i < x.cols(); ++i) {
    if (sheet.mesh.rest(0, i) > 1e-9) continue;
    low = std::min(low, x(1, i));
    high = std::max(high, x(1, i));
  }
  return {force / 0.8, (high - low) / 0.8};
}

/// Young's modulus per length and Poisson's ratio from central differences: off by the square of the strain, 1e-9.
void check_traction(const std::string& name, const SheetMaterial& material, double modulus, double nu) {
  const double strain = 2e-5;
  const Traction plus = pull(material, 1.0 + strain), minus = pull(material, 1.0 - strain);
  check("C2", "traction, " + name + ", E h, N/m", 0.5 * (plus.stress - minus.stress) / strain, modulus, 1e-8);
  check("C2", "traction, " + name + ", Poisson's ratio", -0.5 * (plus.across - minus.across) / strain, nu, 1e-8);
}

TEST(MembraneTraction, GivesTheMaterialBack) {
  // F / w = E h (L' / L - 1), w' / w - 1 = -nu (L' / L - 1).
  for (const auto& [name, law] : laws()) check_traction(name, isotropic_sheet(law, kMembrane, kNu), kMembrane, kNu);
}

TEST(MembraneTraction, GivesTheOrthotropicMaterialBackInEveryDirection) {
  // 1 / E(t) = c^4 / E1 + s^4 / E2 + c^2 s^2 (1 / G - 2 nu / E1); nu(t) likewise. Along 45 degrees: bias extension.
  const SheetMaterial m = woven(0.0);
  for (const int degrees : {0, 30, 45, 90}) {
    const double t = degrees * M_PI / 180.0, c = std::cos(t), s = std::sin(t), cs = c * c * s * s;
    const double e = 1.0 / (std::pow(c, 4) / m.warp + std::pow(s, 4) / m.weft +
                            cs * (1.0 / m.shear - 2.0 * m.poissons_ratio / m.warp));
    const double nu = e * ((std::pow(c, 4) + std::pow(s, 4)) * m.poissons_ratio / m.warp -
                           cs * (1.0 / m.warp + 1.0 / m.weft - 1.0 / m.shear));
    check_traction("orthotropic, " + std::to_string(degrees) + " degrees from the warp", woven(t), e, nu);
  }
}

/// d2W/d strain^2 under the displacement gradient strain h: slope of the work of the border's forces.
double stiffness_under(const SheetMaterial& material, const Eigen::Matrix2d& h) {
  const double strain = 2e-5;
  double sum = 0.0;
  for (const double sign : {1.0, -1.0}) {
    FlatSheet sheet(irregular_mesh(1.0, 0.8, 4, 4, 0.25), material);
    sheet.hold_border(Eigen::Matrix2d::Identity() + sign * strain * h);
    EXPECT_TRUE(find_equilibrium(&sheet.system, sheet.settings).converged);
    const Nodes f = sheet.system.forces();
    for (int i = 0; i < f.cols(); ++i) {
      sum -= sign * f.col(i).head<2>().dot(h * sheet.mesh.rest.col(i).head<2>());
    }
  }
  return sum / (2.0 * strain * face_areas(irregular_mesh(1.0, 0.8, 4, 4, 0.25)).sum());
}

TEST(MembraneShear, GivesTheMaterialBack) {
  // u_x = gamma y: W = G gamma^2 / 2, G = E / (2 (1 + nu)); orthotropic along its axes: its own G.
  const Eigen::Matrix2d shear = (Eigen::Matrix2d() << 0, 1, 0, 0).finished();
  for (const auto& [name, law] : laws()) {
    check("C2", "shear, " + name + ", G h, N/m", stiffness_under(isotropic_sheet(law, kMembrane, kNu), shear),
          kMembrane / (2.0 * (1.0 + kNu)), 1e-8);
  }
  check("C2", "shear, orthotropic, G h, N/m", stiffness_under(woven(0.0), shear), 25.0, 1e-8);
}

TEST(MembraneBiaxial, GivesTheMaterialBack) {
  // u = strain x: W = E h / (1 - nu) strain^2.
  for (const auto& [name, law] : laws()) {
    check("C2", "biaxial, " + name + ", E h / (1 - nu), N/m",
          0.5 * stiffness_under(isotropic_sheet(law, kMembrane, kNu), Eigen::Matrix2d::Identity()),
          kMembrane / (1.0 - kNu), 1e-8);
  }
}

TEST(MembraneTraction, FollowsEachLawAtFiniteStretch) {
  // Uniaxial nominal stress P11 / mu and lateral stretch of the solid, nu = 0.3: the sheet has eliminated its
  // thickness.
  const std::vector<std::pair<SolidLaw, std::string>> columns = {
      {SolidLaw::kHooke, "linear_Hooke"},
      {SolidLaw::kCorotational, "corotational"},
      {SolidLaw::kStVenantKirchhoff, "StVK"},
      {SolidLaw::kNeoHookean, "NeoHookean_log"},
      {SolidLaw::kStableNeoHookean, "StableNeoHookean_Smith2018"},
      {SolidLaw::kMooneyRivlin, "MooneyRivlin_C10eqC01"}};
  int rows = 0;
  for (const TableRow& row : read_rows("D1_uniaxial_nu03.csv")) {
    const double stretch = row("lambda");
    if (stretch < 0.69 || stretch > 2.01) continue;  // beyond, some laws have no stable sheet
    ++rows;
    for (const auto& [law, column] : columns) {
      const SheetMaterial material = isotropic_sheet(law, kMembrane, kNu);
      const Traction measured = pull(material, stretch);
      const std::string what = "sheet, " + column + " at stretch " + row.text("lambda");
      check("D1", what + ", P11/mu", measured.stress / material.shear, row(column + " P11/mu"), 1e-8,
            Tolerance::kAbsolute);
      check("D1", what + ", lateral stretch", measured.across, row(column + " lateral stretch"), 1e-8,
            Tolerance::kAbsolute);
    }
  }
  EXPECT_GE(rows, 8);
}

TEST(LinearMembrane, SwellsByOneOverTheCosine) {
  // e = sym(s R - I) = (s cos t - 1) I: no force at s = 1 / cos t, and one at s = 1. All others: none at s = 1.
  const TriangleMesh mesh = irregular_mesh(1.0, 0.8, 4, 4, 0.25);
  for (const double degrees : {10.0, 30.0, 60.0}) {
    const double t = degrees * M_PI / 180.0;
    const Mat3 turn = Eigen::AngleAxisd(t, Vec3::UnitZ()).toRotationMatrix();
    for (const auto& [name, law] : laws()) {
      const double scale = law == SolidLaw::kHooke ? 1.0 / std::cos(t) : 1.0;
      System system(scale * turn * mesh.rest, Eigen::VectorXd::Ones(mesh.rest.cols()));
      system.add(make_membrane(mesh, isotropic_sheet(law, kMembrane, kNu), 0));
      check("D3", "sheet, " + name + " turned " + std::to_string(degrees) + " degrees, largest force / (E h), m",
            system.forces().cwiseAbs().maxCoeff() / kMembrane, 0.0, 1e-14, Tolerance::kAbsolute);
      if (law != SolidLaw::kHooke) continue;
      system.state.x = turn * mesh.rest;
      EXPECT_GT(system.forces().cwiseAbs().maxCoeff(), 1e-3 * kMembrane * (1.0 - std::cos(t)));
    }
  }
}

TEST(SquareMembrane, VibratesAtItsFrequencies) {
  // omega a sqrt(rho / T) = pi sqrt(m^2 + n^2); stretched by s: a = s a0, rho = rho0 / s^2, T = P / s.
  const double s = 1.1, density = 0.2;
  const int n = 20;
  const TriangleMesh mesh = irregular_mesh(1.0, 1.0, n, n, 0.2);
  System system(s * mesh.rest, triangle_masses(mesh, density));
  const SheetMaterial material = isotropic_sheet(SolidLaw::kNeoHookean, kMembrane, kNu);
  system.add(make_membrane(mesh, material, 0));
  Eigen::Vector2d nominal;
  plane_stress_energy(solid_of(material), Eigen::Vector2d(s, s), &nominal, nullptr);
  const Eigen::VectorXd omega = normal_frequencies(&system, [&](int i) { return on_border(mesh, i); });
  const double unit = s / std::sqrt(nominal[0] / s / (density / (s * s)));
  check("C3", "square membrane, first frequency", omega[0] * unit, 4.442882938, 0.01);
  check("C3", "square membrane, second frequency", omega[1] * unit, 7.024814731, 0.01);
  check("C3", "square membrane, fourth frequency", omega[3] * unit, 8.885765876, 0.02);
}

TEST(SheetStress, IsTheCauchyStress) {
  // Uniaxial: sigma = P / (stretch across) per width; von Mises' stress is its size. Biaxial: von Mises = sigma.
  const TriangleMesh mesh = irregular_mesh(1.0, 0.8, 4, 4, 0.25);
  SheetMaterial material = isotropic_sheet(SolidLaw::kCorotational, kMembrane, kNu);
  const double pulled = 1.2, across = 1.0 - kNu * 0.2;
  const Nodes x = Vec3(pulled, across, 1.0).asDiagonal() * mesh.rest;
  const double sigma = kMembrane * 0.2 / across;
  const Eigen::Matrix2Xf stress = principal_stresses(mesh, material, x);
  EXPECT_NEAR(stress.row(0).minCoeff(), sigma, 1e-4);
  EXPECT_NEAR(stress.row(0).maxCoeff(), sigma, 1e-4);
  EXPECT_NEAR(stress.row(1).cwiseAbs().maxCoeff(), 0.0, 1e-4);
  EXPECT_NEAR(sheet_stress(mesh, material, x).maxCoeff(), sigma, 1e-4);
  material.thickness = 5e-4;
  EXPECT_NEAR(sheet_stress(mesh, material, x).minCoeff(), sigma / 5e-4, 0.2);
}

}  // namespace
}  // namespace deformable_sim::test
