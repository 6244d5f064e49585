// Which nodes are linked and how stiff, against the Born moduli of the lattice.
#include <gtest/gtest.h>

#include <algorithm>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/spring_network.h"

namespace deformable_sim {
namespace {

const SpringLink& find(const std::vector<SpringLink>& links, int a, int b) {
  const auto found = std::find_if(links.begin(), links.end(), [&](const SpringLink& link) {
    return (link.a == a && link.b == b) || (link.a == b && link.b == a);
  });
  if (found == links.end()) throw std::runtime_error("no such link");
  return *found;
}

/// Neighbours of the middle node of a 7 x 7 grid of square cells.
int neighbours(const std::vector<SpringLink>& links, int node) {
  return static_cast<int>(std::count_if(links.begin(), links.end(),
                                        [&](const SpringLink& link) { return link.a == node || link.b == node; }));
}

TEST(GridNetwork, LinksTwelveNeighboursInside) {
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  const SpringNetwork network = sheet_network(make_grid(1, 1, 6, 6), stiffness);
  EXPECT_EQ(neighbours(network.stretch, 24), 4);
  EXPECT_EQ(neighbours(network.shear, 24), 4);
  EXPECT_EQ(neighbours(network.bend, 24), 4);
  EXPECT_EQ(network.stretch.size(), 84u);
  EXPECT_EQ(network.shear.size(), 72u);
  EXPECT_EQ(network.bend.size(), 70u);
}

TEST(GridNetwork, HasTheModuliOfTheMaterial) {
  // Square cells: C11 = k1 + k2 + 4 k3 = E h / (1 - nu^2), C12 = k2 = nu C11.
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  stiffness.poissons_ratio = 0.243;
  const SpringNetwork network = sheet_network(make_grid(1, 1, 6, 6), stiffness);
  const double k1 = find(network.stretch, 23, 24).stiffness, k2 = network.shear[0].stiffness;
  const double k3 = find(network.bend, 22, 24).stiffness;
  const double c11 = k1 + k2 + 4.0 * k3;
  EXPECT_NEAR(c11 - k2 * k2 / c11, 261.0, 1e-9);
  EXPECT_NEAR(k2 / c11, 0.243, 1e-12);
}

TEST(GridNetwork, GivesAFreeEdgeHalf) {
  SheetStiffness stiffness;
  stiffness.stretch = 80.0;
  stiffness.bend = 2.0;
  const SpringNetwork network = sheet_network(make_grid(1, 1, 6, 6), stiffness);
  EXPECT_NEAR(find(network.stretch, 2, 3).stiffness, 40.0, 1e-12);
  EXPECT_NEAR(find(network.stretch, 9, 10).stiffness, 80.0, 1e-12);
  EXPECT_NEAR(find(network.stretch, 9, 16).stiffness, 80.0, 1e-12);
  EXPECT_NEAR(find(network.bend, 2, 4).stiffness, 1.0, 1e-12);
}

TEST(GridNetwork, CarriesTheSameTensionThroughEveryCellOfARow) {
  // At strain e a structural spring carries k1 a e, a bend spring over the cell k3 2a e: their sum must not depend on
  // the cell, though the first and the last one are crossed by one bend spring only.
  SheetStiffness stiffness;
  stiffness.membrane = 261.0;
  const int cells = 6;
  const SpringNetwork network = sheet_network(make_grid(1, 1, cells, cells), stiffness);
  const int row = 3 * (cells + 1);
  std::vector<double> tension;
  for (int c = 0; c < cells; ++c) {
    double sum = find(network.stretch, row + c, row + c + 1).stiffness;
    for (const SpringLink& link : network.bend) {
      if (link.a >= row && link.b <= row + cells && link.a <= row + c && link.b >= row + c + 1)
        sum += 2.0 * link.stiffness;
    }
    tension.push_back(sum);
  }
  for (double t : tension) EXPECT_NEAR(t, tension[2], 1e-12 * tension[2]);
}

TEST(GridNetwork, LeavesOutWhatIsZero) {
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  stiffness.shear = 0.0;
  stiffness.bend = 0.0;
  const SpringNetwork network = sheet_network(make_grid(1, 1, 4, 4), stiffness);
  EXPECT_TRUE(network.shear.empty());
  EXPECT_TRUE(network.bend.empty());
  for (const SpringLink& link : network.stretch) EXPECT_GT(link.stiffness, 0.0);
}

TEST(MeshNetwork, SplitsTheModulusOverItsEdges) {
  // Van Gelder: k = E h (area at the edge) / l^2; direction average E h = sum k l^2 / (3 A), bend springs included.
  TriangleMesh mesh = make_grid(1.0, 0.7, 5, 4);
  mesh.rows = mesh.cols = 0;
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  const SpringNetwork network = sheet_network(mesh, stiffness);
  double sum = 0.0;
  for (const auto* links : {&network.stretch, &network.bend}) {
    for (const SpringLink& link : *links) sum += link.stiffness * link.rest_length * link.rest_length;
  }
  EXPECT_NEAR(sum / (3.0 * 0.7), 100.0, 1e-10);
  EXPECT_EQ(network.stretch.size(), edges_of(mesh).size());
  EXPECT_EQ(network.bend.size(), hinges_of(mesh).size());
  EXPECT_TRUE(network.shear.empty());
}

TEST(LineNetwork, PutsEaInSeries) {
  LineStiffness stiffness;
  stiffness.axial = 50.0;
  stiffness.bend = 0.0;
  stiffness.damping_time = 0.01;
  const SpringNetwork network = line_network(make_line(2.0, 8), stiffness);
  ASSERT_EQ(network.stretch.size(), 8u);
  EXPECT_NEAR(network.stretch[3].stiffness, 200.0, 1e-12);
  EXPECT_NEAR(network.stretch[3].damping, 2.0, 1e-12);
  EXPECT_TRUE(network.bend.empty());
}

TEST(LineNetwork, ClosesALoop) {
  LineStiffness stiffness;
  stiffness.axial = 50.0;
  const SpringNetwork network = line_network(make_ring(2.0, 8), stiffness);
  EXPECT_EQ(network.stretch.size(), 8u);
  EXPECT_EQ(network.bend.size(), 8u);
  EXPECT_NO_THROW(find(network.stretch, 7, 0));
}

TEST(Masses, AddUpToTheBodys) {
  const TriangleMesh grid = make_grid(0.8, 0.5, 5, 3);
  TriangleMesh mesh = grid;
  mesh.rows = mesh.cols = 0;
  EXPECT_NEAR(sheet_masses(grid, 0.15).sum(), 0.15 * 0.4, 1e-15);
  EXPECT_NEAR(sheet_masses(mesh, 0.15).sum(), 0.15 * 0.4, 1e-15);
  EXPECT_GT(sheet_masses(mesh, 0.15).minCoeff(), 0.0);
  EXPECT_NEAR(line_masses(make_line(2.0, 5), 0.1).sum(), 0.2, 1e-15);
  EXPECT_NEAR(line_masses(make_line(2.0, 5), 0.1)[0], 0.02, 1e-15);
}

TEST(Networks, RefuseWhatIsNotAMaterial) {
  const TriangleMesh mesh = make_grid(1, 1, 2, 2);
  SheetStiffness sheet;
  EXPECT_THROW(sheet_network(mesh, sheet), InputError);  // no stiffness at all
  sheet.membrane = -1.0;
  EXPECT_THROW(sheet_network(mesh, sheet), InputError);
  sheet.membrane = 100.0;
  sheet.poissons_ratio = 0.5;
  EXPECT_THROW(sheet_network(mesh, sheet), InputError);
  sheet.poissons_ratio = 0.2;
  sheet.bend = 60.0;  // alone stiffer than the membrane
  EXPECT_THROW(sheet_network(mesh, sheet), InputError);
  LineStiffness line;
  EXPECT_THROW(line_network(make_line(1, 3), line), InputError);
  line.axial = 10.0;
  line.damping_time = -1.0;
  EXPECT_THROW(line_network(make_line(1, 3), line), InputError);
}

}  // namespace
}  // namespace deformable_sim
