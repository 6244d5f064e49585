// Spring networks beyond grids and lines: lists of links, Provot's sheet, lattices of soft bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_moduli.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

Nodes corners() {
  return (Nodes(3, 4) << 0, 1, 1, 0, 0, 0, 2, 2, 0, 0, 0, 0).finished();
}

TEST(ListNetwork, TakesLinksAsTheyAreAndMeasuresMissingLengths) {
  const SpringNetwork network = list_network(corners(), {{0, 1, 0.0, 5.0, 0.1}, {3, 1, 1.5, 7.0, 0.0}});
  ASSERT_EQ(network.stretch.size(), 2u);
  EXPECT_NEAR(network.stretch[0].rest_length, 1.0, 1e-15);
  EXPECT_EQ(network.stretch[1].rest_length, 1.5);
  EXPECT_EQ(network.stretch[1].a, 3);
  EXPECT_EQ(network.stretch[0].damping, 0.1);
  EXPECT_TRUE(network.shear.empty());
  EXPECT_TRUE(network.bend.empty());
}

/// What the refusal of `links` says.
std::string refusal(const std::vector<SpringLink>& links, Nodes nodes = corners()) {
  try {
    list_network(nodes, links);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(ListNetwork, RefusesAndNamesTheLink) {
  const SpringLink good{0, 1, 1.0, 5.0, 0.0};
  EXPECT_NE(refusal({good, {1, 4, 1.0, 5.0, 0.0}}).find("link 1 (1 - 4) names a node that does not exist"),
            std::string::npos);
  EXPECT_NE(refusal({{2, 2, 1.0, 5.0, 0.0}}).find("itself"), std::string::npos);
  EXPECT_NE(refusal({good, {1, 0, 1.0, 5.0, 0.0}}).find("as link 0"), std::string::npos);
  EXPECT_NE(refusal({{0, 1, 1.0, 0.0, 0.0}}).find("stiffness"), std::string::npos);
  EXPECT_NE(refusal({{0, 1, 1.0, 5.0, -1.0}}).find("damping"), std::string::npos);
  EXPECT_NE(refusal({{0, 1, -1.0, 5.0, 0.0}}).find("rest length"), std::string::npos);
  EXPECT_NE(refusal({{0, 1, 0.0, 5.0, 0.0}}, Nodes::Zero(3, 2)).find("coincide"), std::string::npos);
  EXPECT_EQ(refusal({good}), "");
}

TEST(ProvotNetwork, HasItsSpringsOnceEach) {
  // m x n nodes: 2 m n - m - n structural, 2 (m - 1)(n - 1) shear, m (n - 2) + n (m - 2) flexion springs.
  const TriangleMesh grid = make_grid(0.5, 0.3, 5, 3);
  ProvotStiffness stiffness;
  stiffness.structural = 10.0;
  stiffness.shear = 6.0;
  stiffness.flexion = 2.0;
  stiffness.damping_time = 0.01;
  const SpringNetwork network = provot_network(grid, stiffness);
  EXPECT_EQ(network.stretch.size(), 38u);
  EXPECT_EQ(network.shear.size(), 30u);
  EXPECT_EQ(network.bend.size(), 28u);
  std::set<std::pair<int, int>> pairs;
  for (const auto* links : {&network.stretch, &network.shear, &network.bend})
    for (const SpringLink& l : *links) {
      EXPECT_TRUE(pairs.insert(std::minmax(l.a, l.b)).second);
      EXPECT_NEAR(l.rest_length, (grid.rest.col(l.b) - grid.rest.col(l.a)).norm(), 1e-15);
      EXPECT_NEAR(l.damping, 0.01 * l.stiffness, 1e-15);
    }
  const auto stiffness_of = [](const std::vector<SpringLink>& links, int a, int b) {
    for (const SpringLink& l : links)
      if (l.a == a && l.b == b) return l.stiffness;
    return 0.0;
  };
  EXPECT_EQ(stiffness_of(network.stretch, 0, 1), 5.0);   // on an edge
  EXPECT_EQ(stiffness_of(network.stretch, 1, 7), 10.0);  // from an edge inwards
  EXPECT_EQ(stiffness_of(network.stretch, 7, 8), 10.0);  // inside
  EXPECT_EQ(stiffness_of(network.bend, 0, 12), 1.0);     // along the left edge
  EXPECT_EQ(stiffness_of(network.shear, 0, 7), 6.0);
  stiffness.edge = SheetEdge::kFull;
  EXPECT_EQ(stiffness_of(provot_network(grid, stiffness).stretch, 0, 1), 10.0);
}

TEST(ProvotNetwork, RefusesWhatIsNoGridOrNoStiffness) {
  TriangleMesh grid = make_grid(0.5, 0.3, 5, 3);
  ProvotStiffness stiffness;
  EXPECT_THROW(provot_network(grid, stiffness), InputError);  // structural springs are needed
  stiffness.structural = 10.0;
  EXPECT_NO_THROW(provot_network(grid, stiffness));
  EXPECT_TRUE(provot_network(grid, stiffness).shear.empty());
  stiffness.shear = -1.0;
  EXPECT_THROW(provot_network(grid, stiffness), InputError);
  stiffness.shear = 0.0;
  grid.rows = grid.cols = 0;
  EXPECT_THROW(provot_network(grid, stiffness), InputError);
}

TEST(LatticeCells, AreThoseOfABoxInTheOrderOfItsNodes) {
  const TetMesh box = make_box(Vec3(0.3, 0.2, 0.4), {3, 2, 4});
  const auto cells = lattice_cells(box, Vec3(0.1, 0.1, 0.1));
  EXPECT_EQ(cells.size(), 24u);
  for (const LatticeCell& cell : cells)
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 arm = box.rest.col(cell[static_cast<size_t>(corner)]) - box.rest.col(cell[0]);
      EXPECT_LT((arm - 0.1 * Vec3(corner & 1, corner >> 1 & 1, corner >> 2)).norm(), 1e-12);
    }
  EXPECT_THROW(lattice_cells(box, Vec3(0.07, 0.1, 0.1)), InputError);
  TetMesh shaken = box;
  shaken.rest(0, 5) += 0.02;
  EXPECT_THROW(lattice_cells(shaken, Vec3(0.1, 0.1, 0.1)), InputError);
}

TEST(LatticeCells, FillAClosedSurface) {
  // The lattice around a ball of radius 0.5: whole cubes, every node used, no spring without stiffness.
  const TriangleMesh skin = boundary_of(make_box(Vec3(1, 1, 1), {6, 6, 6}));
  TriangleMesh ball;
  std::vector<int> used(static_cast<size_t>(skin.rest.cols()), -1);
  std::vector<Vec3> nodes;
  for (std::array<int, 3> t : skin.triangles) {
    for (int& node : t) {
      int& index = used[static_cast<size_t>(node)];
      if (index < 0) {
        index = static_cast<int>(nodes.size());
        nodes.push_back(0.5 * Vec3(skin.rest.col(node)).normalized());
      }
      node = index;
    }
    ball.triangles.push_back(t);
  }
  ball.rest.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (size_t i = 0; i < nodes.size(); ++i) ball.rest.col(static_cast<Eigen::Index>(i)) = nodes[i];
  const TetMesh lattice = make_lattice_around(ball, 0.2);
  const auto cells = lattice_cells(lattice, Vec3::Constant(0.2));
  EXPECT_EQ(6 * cells.size(), lattice.tets.size());
  const Eigen::VectorXd mass = lattice_masses(lattice.rest, cells, 1000.0);
  EXPECT_GT(mass.minCoeff(), 0.0);
  EXPECT_NEAR(mass.sum(), 1000.0 * 0.008 * static_cast<double>(cells.size()), 1e-9);
  LatticeStiffness stiffness;
  stiffness.youngs_modulus = 1e4;
  const SpringNetwork network = lattice_network(lattice.rest, cells, stiffness);
  for (const auto* links : {&network.stretch, &network.shear})
    for (const SpringLink& l : *links) EXPECT_GT(l.stiffness, 0.0);
  // Born moduli of any union of cells are those of one cell.
  const Mat6 moduli = solid_moduli(lattice.rest, network, 0.008 * static_cast<double>(cells.size()));
  EXPECT_NEAR(moduli(0, 0), 1.2e4, 1e-6);
  EXPECT_NEAR(moduli(0, 1), 0.4e4, 1e-6);
}

TEST(LatticeNetwork, SharesSpringsBetweenCells) {
  // Edges: k/4 on the edge of the body, k/2 on a face, k inside; face diagonals k/2 on the surface.
  const TetMesh box = make_box(Vec3(2, 2, 2), {2, 2, 2});
  const auto cells = lattice_cells(box, Vec3(1, 1, 1));
  LatticeStiffness stiffness;
  stiffness.neighbours = LatticeNeighbours::kBodies;
  stiffness.springs = {{8.0, 4.0, 3.0}};
  stiffness.damping_time = 0.5;
  const SpringNetwork network = lattice_network(box.rest, cells, stiffness);
  const auto count = [](const std::vector<SpringLink>& links, double k) {
    return std::count_if(links.begin(), links.end(), [&](const SpringLink& l) { return l.stiffness == k; });
  };
  EXPECT_EQ(network.stretch.size(), 54u);
  EXPECT_EQ(count(network.stretch, 2.0), 24);
  EXPECT_EQ(count(network.stretch, 4.0), 24);
  EXPECT_EQ(count(network.stretch, 8.0), 6);
  EXPECT_EQ(network.shear.size(), 72u);
  EXPECT_EQ(count(network.shear, 2.0), 48);
  EXPECT_EQ(count(network.shear, 4.0), 24);
  EXPECT_EQ(network.bend.size(), 32u);
  EXPECT_EQ(count(network.bend, 3.0), 32);
  EXPECT_NEAR(network.stretch[0].damping, 0.5 * network.stretch[0].stiffness, 1e-15);
  EXPECT_NEAR(network.bend[0].rest_length, std::sqrt(3.0), 1e-15);
}

TEST(LatticeNetwork, RefusesWhatIsNoMaterial) {
  const TetMesh cube = make_box(Vec3(1, 1, 1), {1, 1, 1}), slab = make_box(Vec3(2, 1, 1), {1, 1, 1});
  const auto cells = lattice_cells(cube, Vec3(1, 1, 1)), long_cells = lattice_cells(slab, Vec3(2, 1, 1));
  LatticeStiffness stiffness;
  EXPECT_THROW(lattice_network(cube.rest, cells, stiffness), InputError);  // no modulus
  stiffness.youngs_modulus = 1e4;
  EXPECT_NO_THROW(lattice_network(cube.rest, cells, stiffness));
  EXPECT_THROW(lattice_network(cube.rest, {}, stiffness), InputError);
  EXPECT_THROW(lattice_network(slab.rest, long_cells, stiffness), InputError);  // too elongated
  stiffness.damping_time = -1.0;
  EXPECT_THROW(lattice_network(cube.rest, cells, stiffness), InputError);
  stiffness.damping_time = 0.0;
  stiffness.springs = {{1.0, 1.0, 0.0}};
  EXPECT_NO_THROW(lattice_network(cube.rest, cells, stiffness));
  EXPECT_THROW(lattice_network(slab.rest, long_cells, stiffness), InputError);  // springs as given: cubes only
  stiffness.springs = {{0.0, 1.0, 0.0}};
  EXPECT_THROW(lattice_network(cube.rest, cells, stiffness), InputError);
}

}  // namespace
}  // namespace deformable_sim
