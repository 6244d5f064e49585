// Errors often copied with mass-spring models, section 0 of the yardsticks: each has its test.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "deformable_sim/core/element/spring.h"
#include "deformable_sim/core/material/spring_moduli.h"
#include "support/linear_response.h"
#include "support/slope.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

TEST(StretchedPair, IsPulledTogetherAndKeepsItsEnergy) {
  // m_i a_i = k (|d| - L) n towards j: relative acceleration -k 0.1 L (1/m_i + 1/m_j), not +.
  Nodes x = Nodes::Zero(3, 2);
  x.col(1) = Vec3(0.66, 0, 0.88);  // |d| = 1.1
  System pair(x, Eigen::Vector2d(0.2, 0.5));
  pair.add(make_springs("spring", {{0, 1, 1.0, 30.0, 0.0}}, 0));
  const Nodes f = pair.forces();
  const Vec3 relative = f.col(1) / 0.5 - f.col(0) / 0.2;
  check("0.1", "relative acceleration of a pair stretched by 10 %, m/s^2", relative.dot(Vec3(0.6, 0, 0.8)), -21.0,
        1e-12);
  const double start = pair.kinetic_energy() + pair.potential_energy();
  const auto integrator = make_integrator("rk4", {});
  for (int k = 0; k < 20000; ++k) pair.step(*integrator, 1e-4);
  check("0.1", "energy of the undamped pair after 2 s, J", pair.kinetic_energy() + pair.potential_energy(), start,
        1e-10);

  System damped(x, Eigen::Vector2d(0.2, 0.5));
  damped.add(make_springs("spring", {{0, 1, 1.0, 0.0, 2.0}}, 0));
  damped.state.v.col(1) = Vec3(0.6, 0, 0.8);  // moving apart at 1 m/s
  check("0.1", "force of the damper on the node that leaves, N", damped.forces().col(1).dot(Vec3(0.6, 0, 0.8)), -2.0,
        1e-12);
}

TEST(SpringJacobian, HasItsTransversePartAndEqualOffDiagonalBlocks) {
  // K = k [n n^T + (1 - L/r)(I - n n^T)], df_i/dx_j = +K = df_j/dx_i, df_i/dx_i = -sum K.
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  double worst = 0.0, asymmetry = 0.0;
  for (int sample = 0; sample < 50; ++sample) {
    const Vec3 d(normal(generator), normal(generator), normal(generator));
    const Spring::Rest rest{d.norm() * (0.2 + 0.05 * sample), 70.0, 0.0};  // from stretched five times to compressed
    const Mat3 k = Spring::stiffness(d, Vec3::Zero(), rest, 1.0, 0.0, Jacobian::kExact);
    Mat3 difference;
    const double h = 1e-5 * d.norm();
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = h * Vec3::Unit(axis);
      difference.col(axis) =
          (Spring::force(d + e, Vec3::Zero(), rest) - Spring::force(d - e, Vec3::Zero(), rest)) / (2.0 * h);
    }
    worst = std::max(worst, (k - difference).norm() / k.norm());
    asymmetry = std::max(asymmetry, (k - k.transpose()).norm() / k.norm());
    const Vec3 n = d.normalized();
    const Mat3 formula =
        rest.stiffness * (n * n.transpose() + (1.0 - rest.length / d.norm()) * (Mat3::Identity() - n * n.transpose()));
    EXPECT_LT((k - formula).norm(), 1e-13 * formula.norm());
    const Mat3 axial = Spring::stiffness(d, Vec3::Zero(), rest, 1.0, 0.0, Jacobian::kAxial);
    EXPECT_LT((axial - rest.stiffness * n * n.transpose()).norm(), 1e-13 * formula.norm());
  }
  check("0.3", "Jacobian of a spring against central differences, relative", worst, 0.0, 1e-6, Tolerance::kAbsolute);
  check("0.3", "asymmetry of the Jacobian, relative", asymmetry, 0.0, 1e-14, Tolerance::kAbsolute);

  Nodes x = Nodes::Zero(3, 3);
  x.col(1) = Vec3(1.2, 0.1, 0.3);
  x.col(2) = Vec3(0.4, 0.9, -0.2);
  System body(x, Eigen::Vector3d(1, 1, 1));
  body.add(make_springs("springs", {{0, 1, 1.0, 40.0, 0.0}, {1, 2, 1.5, 25.0, 0.0}, {0, 2, 0.9, 10.0, 0.0}}, 0));
  const Eigen::MatrixXd k = stiffness_matrix(&body);
  check("0.3", "df_i/dx_j - df_j/dx_i, N/m", (k.block<3, 3>(0, 3) - k.block<3, 3>(3, 0)).norm(), 0.0, 1e-14 * k.norm(),
        Tolerance::kAbsolute);
  const Mat3 sum = k.block<3, 3>(0, 0) + k.block<3, 3>(0, 3) + k.block<3, 3>(0, 6);
  check("0.3", "df_i/dx_i + sum of the others, N/m", sum.norm(), 0.0, 1e-13 * k.norm(), Tolerance::kAbsolute);
}

TEST(CauchyRelation, GivesOneThirdInThePlaneAndOneQuarterInSpace) {
  // Central forces: C12 = C66. Isotropic: nu = 1/3 in two dimensions, 1/4 in three, not 1/4 in both.
  const TriangleMesh grid = make_grid(1.0, 1.0, 5, 5);
  ProvotStiffness provot;
  provot.structural = 100.0;
  provot.shear = 50.0;
  const SpringModuli sheet = constants_of(sheet_moduli(grid.rest, provot_network(grid, provot), 1.0));
  check("0.5", "Poisson's ratio of the isotropic square lattice", sheet.poissons_ratio, 1.0 / 3.0, 1e-12);
  const TetMesh box = make_box(Vec3(1, 1, 1), {3, 3, 3});
  LatticeStiffness stiffness;
  stiffness.youngs_modulus = 1e5;
  const auto cells = lattice_cells(box, Vec3::Constant(1.0 / 3.0));
  const SpringModuli solid = constants_of(solid_moduli(box.rest, lattice_network(box.rest, cells, stiffness), 1.0));
  check("0.5", "Poisson's ratio of the isotropic cubic lattice", solid.poissons_ratio, 0.25, 1e-12);
}

int neighbours(const std::vector<SpringLink>& links, int node) {
  return static_cast<int>(
      std::count_if(links.begin(), links.end(), [&](const SpringLink& l) { return l.a == node || l.b == node; }));
}

TEST(Neighbours, AreTwelveInASheetAndSixEighteenOrTwentySixInALattice) {
  const TriangleMesh grid = make_grid(1.0, 1.0, 6, 6);
  ProvotStiffness provot;
  provot.structural = provot.shear = provot.flexion = 1.0;
  const SpringNetwork sheet = provot_network(grid, provot);
  const int middle = 3 * 7 + 3;
  check("0.6", "structural neighbours", neighbours(sheet.stretch, middle), 4, 0);
  check("0.6", "shear neighbours", neighbours(sheet.shear, middle), 4, 0);
  check("0.6", "flexion neighbours", neighbours(sheet.bend, middle), 4, 0);

  const TetMesh box = make_box(Vec3(1, 1, 1), {4, 4, 4});
  const auto cells = lattice_cells(box, Vec3::Constant(0.25));
  const int inside = (2 * 5 + 2) * 5 + 2;
  for (const auto kind : {LatticeNeighbours::kEdges, LatticeNeighbours::kFaces, LatticeNeighbours::kBodies}) {
    LatticeStiffness stiffness;
    stiffness.neighbours = kind;
    stiffness.youngs_modulus = 1.0;
    const SpringNetwork solid = lattice_network(box.rest, cells, stiffness);
    const int found =
        neighbours(solid.stretch, inside) + neighbours(solid.shear, inside) + neighbours(solid.bend, inside);
    check("0.6", "lattice neighbours of " + std::to_string(static_cast<int>(kind)), found, static_cast<int>(kind), 0);
  }
}

TEST(FlexionSprings, HaveNoLinearBendingStiffness) {
  // Folding by phi shortens the chord 2a by a phi^2 / 4: E = k3 a^2 phi^4 / 32, quartic; and C11 rises by 4 k3.
  const double a = 0.05, k3 = 12.0;
  const auto energy = [&](double phi) {
    Nodes x = Nodes::Zero(3, 3);
    x.col(0) = a * Vec3(-std::cos(0.5 * phi), 0, -std::sin(0.5 * phi));
    x.col(2) = a * Vec3(std::cos(0.5 * phi), 0, -std::sin(0.5 * phi));
    System strip(x, Eigen::Vector3d(1, 1, 1));
    strip.add(make_springs("flexion", {{0, 2, 2.0 * a, k3, 0.0}}, 0));
    return strip.potential_energy();
  };
  std::vector<double> angles, energies;
  for (double phi = 0.2; phi > 0.01; phi *= 0.5) {
    angles.push_back(phi);
    energies.push_back(energy(phi));
  }
  check("0.7", "power of the angle in the energy of a fold", log_slope(angles, energies), 4.0, 1e-3);
  check("0.7", "energy of a fold of 0.0125 rad, J", energies.back(), k3 * a * a * std::pow(angles.back(), 4) / 32.0,
        1e-4);

  const TriangleMesh grid = make_grid(1.0, 1.0, 40, 40);
  ProvotStiffness provot;
  provot.structural = 100.0;
  const double without = sheet_moduli(grid.rest, provot_network(grid, provot), 1.0)(0, 0);
  provot.flexion = k3;
  const double with = sheet_moduli(grid.rest, provot_network(grid, provot), 1.0)(0, 0);
  check("0.7", "rise of C11 with flexion springs over 39/40 of 4 k3, N/m", with - without, 4.0 * k3 * 39.0 / 40.0,
        1e-10);
}

}  // namespace
}  // namespace deformable_sim::test
