// F25: wrinkles of a compressed sheet on an elastic ground, as long as its bending says however stiff its membrane.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "support/sheet_meshes.h"
#include "support/sheets.h"
#include "support/statics.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kLength = 1.0, kShortening = 0.02;  // m, relative
constexpr double kRigidity = 1e-4;                   // N m
constexpr int kHalfWaves = 6, kCells = 30;

double wave_number(int half_waves) {
  return half_waves * M_PI / kLength;
}

/// N/m^3 of the ground, for which a sheet that bends and does not stretch has so many half waves:
/// the energy per area of waves of wave number q that take up a shortening e is e (B q^2 + K / q^2).
double ground() {
  return kRigidity * std::pow(wave_number(kHalfWaves), 4);
}

struct Wrinkles {
  double energy = 0.0, height = 0.0;  // J, m
  int half_waves = 0;                 // of which there is most
};

/// Settles a sheet of an irregular mesh whose ends have come nearer, starting from so many half waves.
Wrinkles settle(double membrane, int half_waves) {
  const TriangleMesh mesh = irregular_mesh(kLength, kLength * 4 / kCells, kCells, 4, 0.3);
  const int n = static_cast<int>(mesh.rest.cols());
  const Eigen::VectorXd area = triangle_masses(mesh, 1.0);
  // Each node is tied to one of the ground, that has moved as if the sheet had stayed flat.
  Nodes both(3, 2 * n);
  both << mesh.rest, mesh.rest;
  both.row(0) *= 1.0 - kShortening;
  System sheet(both, Eigen::VectorXd::Ones(2 * n));
  std::vector<QuadraticWeight> ties;
  for (int i = 0; i < n; ++i) ties.push_back({i, n + i, ground() * area[i]});
  sheet.add(make_membrane(mesh, isotropic_sheet(SolidLaw::kStVenantKirchhoff, membrane, 0.0), 0))
      .add(make_bending(mesh, isotropic_bending(kRigidity, 0.0), 0))
      .add(make_quadratic_links("ground", ties, 0.0, 0));
  const double q = wave_number(half_waves);
  for (int i = 0; i < n; ++i) {
    const double x = mesh.rest(0, i);
    if (x < 1e-9 || x > kLength - 1e-9) {
      sheet.hold(i);
    } else {
      sheet.state.x(2, i) = 2.0 * std::sqrt(kShortening) / q * std::sin(q * x);
    }
  }
  for (int i = 0; i < n; ++i) sheet.hold(n + i);
  StaticSettings settings;
  settings.tolerance = 1e-7;
  settings.largest_move = 0.02;
  settings.iterations = 300;
  const Equilibrium found = find_equilibrium(&sheet, settings);
  EXPECT_TRUE(found.converged && found.stable) << half_waves;

  Wrinkles wrinkles;
  wrinkles.energy = sheet.potential_energy();
  const Eigen::VectorXd z = sheet.state.x.row(2).head(n).transpose();
  wrinkles.height = z.cwiseAbs().maxCoeff();
  double most = 0.0;
  for (int k = 1; k <= 2 * kHalfWaves; ++k) {
    const Eigen::VectorXd wave = (wave_number(k) * mesh.rest.row(0).array()).sin().matrix().transpose();
    const double part = std::abs(z.cwiseProduct(area).dot(wave));
    if (part > most) wrinkles.half_waves = k;
    most = std::max(most, part);
  }
  return wrinkles;
}

/// The wavelength of least energy: U(n) = a n^2 + b / n^2 through what one half wave less, as many and one more cost.
double preferred_wavelength(double membrane, const std::string& what) {
  Eigen::Matrix<double, 3, 2> powers;
  Eigen::Vector3d energy;
  for (int k = 0; k < 3; ++k) {
    const int n = kHalfWaves - 1 + k;
    const Wrinkles wrinkles = settle(membrane, n);
    EXPECT_EQ(wrinkles.half_waves, n) << what;
    powers.row(k) << n * n, 1.0 / (n * n);
    energy[k] = wrinkles.energy;
    // Length is kept: (A q)^2 / 4 = e, to the order of e.
    if (n == kHalfWaves)
      check("F25", "height of wrinkles, m, " + what, wrinkles.height, 2.0 * std::sqrt(kShortening) / wave_number(n),
            0.05);
  }
  const Eigen::Vector2d fit = powers.colPivHouseholderQr().solve(energy);
  return 2.0 * kLength / std::pow(fit[1] / fit[0], 0.25);
}

TEST(Wrinkles, AreAsLongAsBendingSaysHoweverStiffTheMembrane) {
  // lambda = 2 pi (B / K)^(1/4), whatever E h, as long as the sheet would rather bend: with E h times 1, 0.1 and 0.01
  // it tends to a limit. A mesh that locks cannot bend along directions that its edges do not have without stretching,
  // and makes its wrinkles the longer the stiffer it is: thickness sqrt(12 B / (E h)) = 1/400 of a cell here.
  const double expected = 2.0 * M_PI * std::pow(kRigidity / ground(), 0.25);
  std::array<double, 3> wavelength{};
  const std::array<double, 3> stiffness = {2e5, 2e4, 2e3};  // N/m
  for (size_t k = 0; k < 3; ++k) {
    const std::string what = "E h = " + std::to_string(static_cast<int>(stiffness[k])) + " N/m";
    wavelength[k] = preferred_wavelength(stiffness[k], what);
    check("F25", "wavelength of wrinkles, m, " + what, wavelength[k], expected, 0.02);
  }
  check("F25", "wavelength with a hundredth of E h over that with a tenth", wavelength[2] / wavelength[1], 1.0, 0.005);
  EXPECT_LT(std::abs(wavelength[2] - wavelength[1]), std::abs(wavelength[1] - wavelength[0]));
}

}  // namespace
}  // namespace deformable_sim::test
