// C2: the testing machines of the course on spring networks, small strains: what they find is the closed form of the
// lattice (C1), on every cell count, and what central springs cannot be is reported.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/material/spring_moduli.h"
#include "support/linear_response.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

struct Found {
  double modulus, ratio;
};

/// Pulls a specimen, centred on the origin, along x with a uniform stress (N/m^2, sheets N/m) at both ends; weights are
/// the area (width) that belongs to each node there. Rollers on the middle planes keep it in place.
Found pull(System* specimen, const Nodes& rest, const Eigen::VectorXd& weight, double stress, int dimensions) {
  const double end = rest.row(0).maxCoeff();
  Nodes force = Nodes::Zero(3, rest.cols());
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(rest.cols()); ++i) {
    if (std::abs(std::abs(rest(0, i)) - end) < 1e-9) force(0, i) = std::copysign(stress * weight[i], rest(0, i));
    for (int axis = 0; axis < dimensions; ++axis)
      if (std::abs(rest(axis, i)) > 1e-9) free.push_back(3 * i + axis);
  }
  const Nodes u = linear_displacement(specimen, free, force, Nodes::Zero(3, rest.cols()));
  Eigen::Index at_x = 0, at_y = 0;
  rest.row(0).maxCoeff(&at_x);
  rest.row(1).maxCoeff(&at_y);
  const double along = u(0, at_x) / rest(0, at_x);
  return {stress / along, -u(1, at_y) / rest(1, at_y) / along};
}

/// Imposes u = gradient x on the surface (`fixed` nodes) and returns the work it takes, 2 W / measure = e : C : e.
double impose(System* specimen, const Nodes& rest, const Mat3& gradient, const std::vector<char>& fixed, int dimensions,
              double measure) {
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(rest.cols()); ++i)
    if (!fixed[static_cast<size_t>(i)])
      for (int axis = 0; axis < dimensions; ++axis) free.push_back(3 * i + axis);
  const Nodes u = linear_displacement(specimen, free, Nodes::Zero(3, rest.cols()), gradient * rest);
  EXPECT_LT((u - gradient * rest).norm(), 1e-10 * u.norm());  // the patch test: what is inside moves affinely
  const Eigen::Map<const Eigen::VectorXd> flat(u.data(), u.size());
  return flat.dot(stiffness_matrix(specimen) * flat) / measure;
}

std::vector<char> on_surface(const Nodes& rest, int dimensions) {
  std::vector<char> surface(static_cast<size_t>(rest.cols()), 0);
  for (Eigen::Index i = 0; i < rest.cols(); ++i)
    for (int axis = 0; axis < dimensions; ++axis)
      if (std::abs(rest(axis, i) - rest.row(axis).minCoeff()) < 1e-9 ||
          std::abs(rest(axis, i) - rest.row(axis).maxCoeff()) < 1e-9)
        surface[static_cast<size_t>(i)] = 1;
  return surface;
}

TEST(SheetBench, FindsTheClosedFormOfTheSquareLattice) {
  // E h = k1 (k1 + 2 k2) / (k1 + k2), nu = k2 / (k1 + k2), G h = k2, on any number of cells.
  const double k1 = 120.0, k2 = 45.0;
  for (const auto& [cells_x, cells_y] : {std::array<int, 2>{10, 2}, {10, 4}, {20, 4}}) {
    const double a = 0.5 / cells_x, width = a * cells_y;
    const TriangleMesh grid = make_grid(0.5, width, cells_x, cells_y);
    ProvotStiffness stiffness;
    stiffness.structural = k1;
    stiffness.shear = k2;
    System strip(grid.rest, sheet_masses(grid, 0.15));
    strip.add_springs(provot_network(grid, stiffness));
    Eigen::VectorXd weight = Eigen::VectorXd::Constant(grid.rest.cols(), a);
    for (Eigen::Index i = 0; i < weight.size(); ++i)
      if (std::abs(std::abs(grid.rest(1, i)) - 0.5 * width) < 1e-9) weight[i] = 0.5 * a;
    const Found found = pull(&strip, grid.rest, weight, 3.0, 2);
    const std::string name = "Provot sheet of " + std::to_string(cells_x) + " x " + std::to_string(cells_y) + " cells";
    check("C2", "traction, " + name + ", E h, N/m", found.modulus, k1 * (k1 + 2.0 * k2) / (k1 + k2), 1e-8);
    check("C2", "traction, " + name + ", Poisson's ratio", found.ratio, k2 / (k1 + k2), 1e-8);
    Mat3 shear = Mat3::Zero();
    shear(0, 1) = 1.0;
    check("C2", "shear, " + name + ", G h, N/m",
          impose(&strip, grid.rest, shear, on_surface(grid.rest, 2), 2, 0.5 * width), k2, 1e-8);
  }
}

TEST(SheetBench, FindsTheBiasModulus) {
  // E_45 = 4 k2 (k1 + 2 k2) / (k1 + 4 k2): pulled along the diagonals, 1 / S11 of the turned compliance.
  const double k1 = 120.0, k2 = 45.0;
  const TriangleMesh grid = make_grid(0.4, 0.4, 4, 4);
  ProvotStiffness stiffness;
  stiffness.structural = k1;
  stiffness.shear = k2;
  const SpringNetwork network = provot_network(grid, stiffness);
  const Nodes turned = Eigen::AngleAxisd(M_PI / 4.0, Vec3::UnitZ()).toRotationMatrix() * grid.rest;
  check("C2", "bias extension of a Provot sheet, E_45 h, N/m",
        constants_of(sheet_moduli(turned, network, 0.16)).youngs_modulus[0],
        4.0 * k2 * (k1 + 2.0 * k2) / (k1 + 4.0 * k2), 1e-8);
}

TEST(BlockBench, FindsTheClosedFormOfTheIsotropicLattice) {
  // E as given, nu = 1/4, G = E / 2.5, B = E / (3 (1 - 2 nu)) = 2 E / 3, on any number of cells.
  const double modulus = 2e4;
  for (const auto kind : {LatticeNeighbours::kFaces, LatticeNeighbours::kBodies}) {
    for (const int n : {2, 4}) {
      const Vec3 size(0.4, 0.2, 0.2);
      const double a = 0.2 / n;
      const TetMesh box = make_box(size, {2 * n, n, n});
      const auto cells = lattice_cells(box, Vec3::Constant(a));
      LatticeStiffness stiffness;
      stiffness.neighbours = kind;
      stiffness.youngs_modulus = modulus;
      System block(box.rest, lattice_masses(box.rest, cells, 1000.0));
      block.add_springs(lattice_network(box.rest, cells, stiffness));
      Eigen::VectorXd weight(box.rest.cols());
      for (Eigen::Index i = 0; i < weight.size(); ++i) {
        const auto share = [&](int axis) { return std::abs(std::abs(box.rest(axis, i)) - 0.1) < 1e-9 ? 0.5 * a : a; };
        weight[i] = share(1) * share(2);
      }
      const std::string name =
          std::to_string(static_cast<int>(kind)) + " neighbours, " + std::to_string(n) + " cells across";
      const Found found = pull(&block, box.rest, weight, 100.0, 3);
      check("C2", "traction, lattice of " + name + ", E, Pa", found.modulus, modulus, 1e-8);
      check("C2", "traction, lattice of " + name + ", Poisson's ratio", found.ratio, 0.25, 1e-8);
      const std::vector<char> surface = on_surface(box.rest, 3);
      Mat3 shear = Mat3::Zero();
      shear(0, 1) = 1.0;
      check("C2", "shear, lattice of " + name + ", G, Pa", impose(&block, box.rest, shear, surface, 3, size.prod()),
            modulus / 2.5, 1e-8);
      check("C2", "compression, lattice of " + name + ", B, Pa",
            impose(&block, box.rest, Mat3(-Mat3::Identity()), surface, 3, size.prod()) / 9.0, 2.0 * modulus / 3.0,
            1e-8);
    }
  }
}

TEST(SpringGap, SaysWhatCentralSpringsCannotBe) {
  // A material of nu = 0.45 becomes one of nu = 1/4: the gap is said, with both sets of constants; none where they
  // agree.
  const TetMesh box = make_box(Vec3(1, 1, 1), {2, 2, 2});
  const auto cells = lattice_cells(box, Vec3::Constant(0.5));
  LatticeStiffness stiffness;
  stiffness.youngs_modulus = 5e4;
  const SpringModuli found = constants_of(solid_moduli(box.rest, lattice_network(box.rest, cells, stiffness), 1.0));
  EXPECT_EQ(spring_gap(5e4, 0.25, found), "");
  const std::string gap = spring_gap(5e4, 0.45, found);
  EXPECT_NE(gap.find("0.45"), std::string::npos) << gap;
  EXPECT_NE(gap.find("0.25"), std::string::npos) << gap;
  check("C2", "shear modulus got over that of nu = 0.45", found.shear_modulus * 2.0 * 1.45 / 5e4, 1.45 / 1.25, 1e-8);

  const TriangleMesh grid = make_grid(1.0, 1.0, 4, 4);
  SheetStiffness sheet;
  sheet.membrane = 261.0;
  sheet.poissons_ratio = 0.243;
  const SpringModuli got = constants_of(sheet_moduli(grid.rest, sheet_network(grid, sheet), 1.0));
  EXPECT_NE(spring_gap(261.0, 0.243, got), "");  // G h = C12 = nu E h / (1 - nu^2)
  check("C2", "grid of nu = 0.243, G h got, N/m", got.shear_modulus, 0.243 * 261.0 / (1.0 - 0.243 * 0.243), 1e-8);
  sheet.poissons_ratio = 1.0 / 3.0;
  EXPECT_EQ(spring_gap(261.0, 1.0 / 3.0, constants_of(sheet_moduli(grid.rest, sheet_network(grid, sheet), 1.0))), "");
}

}  // namespace
}  // namespace deformable_sim::test
