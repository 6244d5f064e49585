// C1: the moduli of spring lattices, measured on finite patches by imposed strains, and their highest frequencies
// (C1c).
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "deformable_sim/core/material/spring_moduli.h"
#include "support/linear_response.h"
#include "support/table.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

Nodes affine(const Nodes& rest, const Mat3& gradient) {
  return gradient * rest;
}

/// e1 : C : e2 of a patch at rest under affine displacements u = e x: u1^T K u2 over its measure (m^2 or m^3).
double modulus(System* patch, const Nodes& rest, const Mat3& e1, const Mat3& e2, double measure) {
  const Nodes u1 = affine(rest, e1), u2 = affine(rest, e2);
  const Eigen::MatrixXd k = stiffness_matrix(patch);
  return Eigen::Map<const Eigen::VectorXd>(u1.data(), u1.size())
             .dot(k * Eigen::Map<const Eigen::VectorXd>(u2.data(), u2.size())) /
         measure;
}

Mat3 unit_strain(int a, int b) {
  Mat3 e = Mat3::Zero();
  e(a, b) = 1.0;
  return e;
}

/// A square patch whose rows and columns close on themselves: every cell is inside. Returns K of one cell's springs as
/// moduli C_ab of the sheet, by energy: all springs that start at one inner node.
Mat3 periodic_moduli(const ProvotStiffness& stiffness) {
  const TriangleMesh grid = make_grid(1.0, 1.0, 6, 6);
  const SpringNetwork all = provot_network(grid, stiffness);
  const int middle = 3 * 7 + 3;
  SpringNetwork cell;  // half of the springs at the middle node stand for those of its cell
  for (const auto* links : {&all.stretch, &all.shear, &all.bend})
    for (SpringLink link : *links)
      if (link.a == middle || link.b == middle) {
        link.stiffness *= 0.5;
        cell.stretch.push_back(link);
      }
  return sheet_moduli(grid.rest, cell, 1.0 / 36.0);
}

/// k1, k2, k3 of the rows of C1_lattice_moduli_2D.csv that are square lattices with both diagonals.
const std::map<std::string, std::array<double, 3>> kSquare = {
    {"square structural k1=1, shear k2=0, flexion k3=0", {1, 0, 0}},
    {"square structural k1=1, shear k2=1, flexion k3=0", {1, 1, 0}},
    {"square structural k1=1, shear k2=0.5, flexion k3=0", {1, 0.5, 0}},
    {"square structural k1=1, shear k2=0.1, flexion k3=0", {1, 0.1, 0}},
    {"square structural k1=1, shear k2=0.01, flexion k3=0", {1, 0.01, 0}},
    {"square structural k1=1, shear k2=1, flexion k3=1", {1, 1, 1}},
    {"square structural k1=1, shear k2=0.5, flexion k3=0.5", {1, 0.5, 0.5}},
    {"square structural k1=1, shear k2=0.5, flexion k3=0.25", {1, 0.5, 0.25}},
    {"square structural k1=1, shear k2=1, flexion k3=0.1", {1, 1, 0.1}}};

TEST(SquareLattice, HasTheModuliOfBorn) {
  // C11 = k1 + k2 + 4 k3, C12 = C66 = k2, on a periodic patch; E_45 = 1 / S_11 of the moduli turned by 45 degrees.
  int compared = 0;
  for (const TableRow& row : read_rows("C1_lattice_moduli_2D.csv")) {
    const std::string& name = row.text("lattice (units of k1)");
    if (kSquare.count(name) == 0) continue;
    ProvotStiffness stiffness;
    stiffness.structural = kSquare.at(name)[0];
    stiffness.shear = kSquare.at(name)[1];
    stiffness.flexion = kSquare.at(name)[2];
    const Mat3 moduli = periodic_moduli(stiffness);
    check("C1", name + ", C11", moduli(0, 0), row("C11"), 1e-8);
    check("C1", name + ", C12", moduli(0, 1), row("C12"), 1e-8, Tolerance::kAbsolute);
    check("C1", name + ", C66", moduli(2, 2), row("C66"), 1e-8, Tolerance::kAbsolute);
    const SpringModuli found = constants_of(moduli);
    check("C1", name + ", E", found.youngs_modulus[0], row("E_warp(2D) N/m per k1"), 1e-8);
    check("C1", name + ", nu", found.poissons_ratio, row("nu_warp"), 1e-8, Tolerance::kAbsolute);
    ++compared;
  }
  EXPECT_EQ(compared, static_cast<int>(kSquare.size()));
}

TEST(SquareLattice, HasThemOnAFinitePatchWhoseEdgesCarryHalf) {
  // Without flexion every cell has the infinite lattice's moduli once edge springs are halved; with full ones an n-cell
  // strip is (n + 1) / n too stiff.
  const int n = 5;
  const TriangleMesh grid = make_grid(0.5, 0.5, n, n);
  ProvotStiffness stiffness;
  stiffness.structural = 90.0;
  stiffness.shear = 35.0;
  const auto patch = [&](SheetEdge edge) {
    stiffness.edge = edge;
    auto body = std::make_unique<System>(grid.rest, sheet_masses(grid, 0.1));
    body->add_springs(provot_network(grid, stiffness));
    return body;
  };
  auto corrected = patch(SheetEdge::kHalved);
  const Mat3 xx = unit_strain(0, 0), yy = unit_strain(1, 1), xy = unit_strain(0, 1);
  check("C1", "finite square patch, C11, N/m", modulus(corrected.get(), grid.rest, xx, xx, 0.25), 125.0, 1e-10);
  check("C1", "finite square patch, C12, N/m", modulus(corrected.get(), grid.rest, xx, yy, 0.25), 35.0, 1e-10);
  check("C1", "finite square patch, C66, N/m", modulus(corrected.get(), grid.rest, xy, xy, 0.25), 35.0, 1e-10);
  auto uncorrected = patch(SheetEdge::kFull);
  check("C1", "the same without halved edges: k1 (n + 1) / n + k2, N/m",
        modulus(uncorrected.get(), grid.rest, xx, xx, 0.25), 90.0 * (n + 1) / n + 35.0, 1e-10);
}

TEST(CalibratedGrid, HasTheAskedForModuliOnAFinitePatch) {
  // E h and nu in: C11 = E h / (1 - nu^2), C12 = nu C11 out, bend springs and their end corrections included.
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  stiffness.poissons_ratio = 0.243;
  stiffness.bend = 4.0;
  for (const auto& [cells_x, cells_y] : {std::array<int, 2>{4, 4}, {7, 5}, {9, 12}}) {
    const TriangleMesh grid = make_grid(0.5, 0.4, cells_x, cells_y);
    const SpringModuli found = constants_of(sheet_moduli(grid.rest, sheet_network(grid, stiffness), 0.2));
    const std::string size = std::to_string(cells_x) + " x " + std::to_string(cells_y) + " cells";
    check("C1", "grid of " + size + ", E h along x, N/m", found.youngs_modulus[0], 261.0, 1e-8);
    check("C1", "grid of " + size + ", E h along y, N/m", found.youngs_modulus[1], 261.0, 1e-8);
    check("C1", "grid of " + size + ", nu", found.poissons_ratio, 0.243, 1e-8);
  }
}

TEST(TriangularLattice, HasTheModuliOfBorn) {
  // Equilateral, k = E h sqrt(3)/2 in Van Gelder's formula gives back E h = 2 k / sqrt 3 and nu = 1/3 for inner
  // springs.
  const TableRow row = read_rows("C1_lattice_moduli_2D.csv").front();
  SpringNetwork cell;  // three springs a node, area sqrt(3)/2
  Nodes rest = Nodes::Zero(3, 4);
  for (int i = 0; i < 3; ++i) {
    rest.col(i + 1) = Vec3(std::cos(M_PI * i / 3.0), std::sin(M_PI * i / 3.0), 0);
    cell.stretch.push_back({0, i + 1, 1.0, 1.0, 0.0});
  }
  const Mat3 moduli = sheet_moduli(rest, cell, std::sqrt(0.75));
  const SpringModuli found = constants_of(moduli);
  check("C1", "equilateral lattice, C11", moduli(0, 0), row("C11"), 1e-8);
  check("C1", "equilateral lattice, E", found.youngs_modulus[0], row("E_warp(2D) N/m per k1"), 1e-8);
  check("C1", "equilateral lattice, nu", found.poissons_ratio, row("nu_warp"), 1e-8);
  // The inner edges of an equilateral mesh of E h have Van Gelder's k = E h A / l^2 with A the two faces at the edge.
  TriangleMesh mesh;
  mesh.rest = Nodes::Zero(3, 4);
  mesh.rest.col(1) = Vec3(1, 0, 0);
  mesh.rest.col(2) = Vec3(0.5, std::sqrt(0.75), 0);
  mesh.rest.col(3) = Vec3(1.5, std::sqrt(0.75), 0);
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  SheetStiffness stiffness;
  stiffness.membrane = 2.0 / std::sqrt(3.0);
  stiffness.bend = 0.0;
  for (const SpringLink& link : sheet_network(mesh, stiffness).stretch)
    if (link.a == 1 && link.b == 2) check("C1", "Van Gelder's inner spring, N/m", link.stiffness, 1.0, 1e-8);
}

/// k1, k2, k3 of the rows of C1_lattice_moduli_3D.csv.
const std::map<std::string, std::array<double, 3>> kCubic = {
    {"cubic edges k1=1 only", {1, 0, 0}},
    {"edges 1 + face diagonals 1", {1, 1, 0}},
    {"edges 1 + body diagonals 3/8 (isotropic)", {1, 0, 0.375}},
    {"edges 1 + face 1 (isotropic: k1=k2+8/3 k3)", {1, 1, 0}},
    {"edges 11/3, face 1, body 1 (isotropic)", {11.0 / 3.0, 1, 1}},
    {"edges 1, face .5, body .25", {1, 0.5, 0.25}},
    {"edges 1, face 1, body 1", {1, 1, 1}}};

struct Block {
  TetMesh mesh;
  std::vector<LatticeCell> cells;
};

Block block(const Vec3& size, const std::array<int, 3>& count) {
  Block b;
  b.mesh = make_box(size, count);
  b.cells = lattice_cells(b.mesh, Vec3(size[0] / count[0], size[1] / count[1], size[2] / count[2]));
  return b;
}

TEST(CubicLattice, HasTheModuliOfBornOnAFinitePatch) {
  // C11 = (k1 + 2 k2 + 4 k3/3) / a, C12 = C44 = (k2 + 4 k3/3) / a, measured by imposed strains on 3 x 2 x 2 cells.
  const double a = 0.1;
  const Block b = block(Vec3(3 * a, 2 * a, 2 * a), {3, 2, 2});
  int compared = 0;
  for (const TableRow& row : read_rows("C1_lattice_moduli_3D.csv")) {
    const std::string& name = row.text("lattice (units k/a)");
    ASSERT_EQ(kCubic.count(name), 1u) << name;
    LatticeStiffness stiffness;
    stiffness.neighbours = LatticeNeighbours::kBodies;
    stiffness.springs = kCubic.at(name);
    System body(b.mesh.rest, lattice_masses(b.mesh.rest, b.cells, 1000.0));
    const SpringNetwork network = lattice_network(b.mesh.rest, b.cells, stiffness);
    body.add_springs(network);
    const double volume = 12.0 * a * a * a;
    const auto c = [&](int i, int j, int k, int l) {
      return a * modulus(&body, b.mesh.rest, unit_strain(i, j), unit_strain(k, l), volume);
    };
    for (int axis = 0; axis < 3; ++axis) {
      const int next = (axis + 1) % 3;
      check("C1", name + ", C" + std::to_string(11 * (axis + 1)) + " a", c(axis, axis, axis, axis), row("C11*a"), 1e-8);
      check("C1", name + ", C12 a, axis " + std::to_string(axis), c(axis, axis, next, next), row("C12*a"), 1e-8,
            Tolerance::kAbsolute);
      check("C1", name + ", C44 a, axis " + std::to_string(axis), c(axis, next, axis, next), row("C44*a"), 1e-8,
            Tolerance::kAbsolute);
    }
    const SpringModuli found = constants_of(solid_moduli(b.mesh.rest, network, volume));
    check("C1", name + ", E a", a * found.youngs_modulus[0], row("E*a"), 1e-8);
    check("C1", name + ", nu", found.poissons_ratio, row("nu"), 1e-8, Tolerance::kAbsolute);
    check("C1", name + ", G a", a * found.shear_modulus, row("G*a"), 1e-8, Tolerance::kAbsolute);
    ++compared;
  }
  EXPECT_EQ(compared, 7);
}

TEST(CalibratedLattice, IsIsotropicWithTheAskedForModulus) {
  // E in, E and nu = 1/4 and G = E / 2.5 out along every axis, cubes or not, 18 or 26 neighbours; 6: E and nothing
  // else.
  for (const auto kind : {LatticeNeighbours::kFaces, LatticeNeighbours::kBodies}) {
    for (const Vec3& cell : {Vec3(0.1, 0.1, 0.1), Vec3(0.1, 0.11, 0.095)}) {
      const Block b = block(cell.cwiseProduct(Vec3(2, 3, 2)), {2, 3, 2});
      LatticeStiffness stiffness;
      stiffness.neighbours = kind;
      stiffness.youngs_modulus = 5e4;
      const SpringNetwork network = lattice_network(b.mesh.rest, b.cells, stiffness);
      const Mat6 moduli = solid_moduli(b.mesh.rest, network, 12.0 * cell.prod());
      const SpringModuli found = constants_of(moduli);
      const std::string name = std::to_string(static_cast<int>(kind)) + " neighbours, cell " + std::to_string(cell[1]);
      for (int axis = 0; axis < 3; ++axis) {
        check("C1", name + ", E, Pa, axis " + std::to_string(axis), found.youngs_modulus[axis], 5e4, 1e-8);
        check("C1", name + ", G, Pa, axis " + std::to_string(axis), moduli(3 + axis, 3 + axis), 2e4, 1e-8);
      }
      check("C1", name + ", nu", found.poissons_ratio, 0.25, 1e-8);
    }
  }
  const Block b = block(Vec3(0.2, 0.3, 0.2), {2, 2, 2});
  LatticeStiffness edges;
  edges.neighbours = LatticeNeighbours::kEdges;
  edges.youngs_modulus = 5e4;
  const SpringModuli found =
      constants_of(solid_moduli(b.mesh.rest, lattice_network(b.mesh.rest, b.cells, edges), 0.012));
  check("C1", "6 neighbours, E along y, Pa", found.youngs_modulus[1], 5e4, 1e-8);
  check("C1", "6 neighbours, G, Pa", found.shear_modulus, 0.0, 1e-8, Tolerance::kAbsolute);
}

/// Highest omega^2 m of Bloch waves u exp(i q.x) of the lattice whose springs at one node are `links`: largest
/// eigenvalue of sum k n n^T (1 - cos q.d) over all neighbours and all q. Maximised from a raster by bisection.
double highest_square(const Nodes& rest, const std::vector<SpringLink>& links, int node, int dimensions, double a) {
  std::vector<std::pair<Vec3, double>> springs;
  for (const SpringLink& l : links)
    if (l.a == node || l.b == node) springs.emplace_back(rest.col(l.b) - rest.col(l.a), l.stiffness);
  const auto largest = [&](const Vec3& q) {
    Mat3 d = Mat3::Zero();
    for (const auto& [arm, k] : springs)
      d += k * (1.0 - std::cos(q.dot(arm))) * arm * arm.transpose() / arm.squaredNorm();
    return Eigen::SelfAdjointEigenSolver<Mat3>(d, Eigen::EigenvaluesOnly).eigenvalues()[2];
  };
  const int n = 16;
  double best = 0.0;
  Vec3 at = Vec3::Zero();
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= (dimensions > 1 ? n : 0); ++j)
      for (int k = 0; k <= (dimensions > 2 ? n : 0); ++k) {
        const Vec3 q = M_PI / (a * n) * Vec3(i, j, k);
        if (largest(q) <= best) continue;
        best = largest(q);
        at = q;
      }
  for (double step = M_PI / (a * n); step > 1e-7 / a; step *= 0.5)
    for (bool better = true; better;) {
      better = false;
      for (int axis = 0; axis < dimensions; ++axis)
        for (const double sign : {-1.0, 1.0}) {
          const Vec3 q = at + sign * step * Vec3::Unit(axis);
          if (largest(q) <= best * (1.0 + 1e-14)) continue;
          best = largest(q);
          at = q;
          better = true;
        }
    }
  return best;
}

std::vector<SpringLink> all_links(const SpringNetwork& network) {
  std::vector<SpringLink> links = network.stretch;
  links.insert(links.end(), network.shear.begin(), network.shear.end());
  links.insert(links.end(), network.bend.begin(), network.bend.end());
  return links;
}

TEST(Lattices, HaveTheHighestFrequencyOfTheirBlochWaves) {
  // omega_max^2 m / k1 of infinite lattices: 4 + 4 k2 without flexion; with it the wave q along the diagonal, of
  // 2 k1 (1 - c) + 4 (k2 + k3)(1 - c^2), c = cos q a: 2 k1 + 4 K + k1^2 / (4 K), K = k2 + k3. In space 4, 4 + 8 k2
  // with faces, 6 with 3/8 of body diagonals, 52/3 with all three alike.
  const TriangleMesh grid = make_grid(6.0, 6.0, 6, 6);
  const std::map<std::array<double, 3>, double> sheets = {
      {{1, 0, 0}, 4.0}, {{1, 0.5, 0}, 6.0}, {{1, 1, 0}, 8.0}, {{1, 1, 1}, 10.125}, {{1, 0.5, 0.5}, 6.25}};
  for (const auto& [k, expected] : sheets) {
    ProvotStiffness stiffness;
    stiffness.structural = k[0];
    stiffness.shear = k[1];
    stiffness.flexion = k[2];
    check("C1c", "square lattice, k2 = " + std::to_string(k[1]) + ", k3 = " + std::to_string(k[2]),
          highest_square(grid.rest, all_links(provot_network(grid, stiffness)), 24, 2, 1.0), expected, 1e-8);
  }
  const Block b = block(Vec3(4, 4, 4), {4, 4, 4});
  const std::map<std::array<double, 3>, double> solids = {
      {{1, 0, 0}, 4.0}, {{1, 1, 0}, 12.0}, {{1, 0, 0.375}, 6.0}, {{1, 1, 1}, 52.0 / 3.0}};
  for (const auto& [k, expected] : solids) {
    LatticeStiffness stiffness;
    stiffness.neighbours = LatticeNeighbours::kBodies;
    stiffness.springs = k;
    check("C1c", "cubic lattice, k2 = " + std::to_string(k[1]) + ", k3 = " + std::to_string(k[2]),
          highest_square(b.mesh.rest, all_links(lattice_network(b.mesh.rest, b.cells, stiffness)), 62, 3, 1.0),
          expected, 1e-8);
  }
}

TEST(FreeChain, HasTheHighestFrequencyOfItsLength) {
  // N + 1 equal masses, free ends: omega = 2 sqrt(k/m) cos(pi / (2 (N + 1))), towards 2 sqrt(k/m): found by the
  // estimate that explicit schemes choose their step with.
  for (const int n : {3, 30}) {
    const Polyline line = make_line(n, n);
    LineStiffness stiffness;
    stiffness.stretch = 50.0;
    stiffness.bend = 0.0;
    System chain(line.rest, Eigen::VectorXd::Constant(n + 1, 0.02));
    chain.add_springs(line_network(line, stiffness));
    check("C1c", "free chain of " + std::to_string(n) + " springs, rad/s",
          highest_frequency(chain.dynamics, chain.state),
          2.0 * std::sqrt(50.0 / 0.02) * std::cos(M_PI / (2.0 * (n + 1))), 1e-3);
  }
}

}  // namespace
}  // namespace deformable_sim::test
