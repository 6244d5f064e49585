// Rest shapes: counts, windings, derived stencils, refusals.
#include <gtest/gtest.h>

#include <string>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/polyline.h"
#include "deformable_sim/core/topology/triangle_mesh.h"

namespace deformable_sim {
namespace {

template <class Function>
std::string refusal_of(Function function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

#define EXPECT_MENTIONS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TriangleMesh square_of_two() {
  TriangleMesh mesh;
  mesh.rest = (Nodes(3, 4) << 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0).finished();
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(Grid, HasNodesRowByRowAndCentredOnTheOrigin) {
  const TriangleMesh mesh = make_grid(0.8, 0.3, 4, 2);
  EXPECT_EQ(mesh.rows, 3);
  EXPECT_EQ(mesh.cols, 5);
  ASSERT_EQ(mesh.rest.cols(), 15);
  EXPECT_LT((mesh.rest.col(0) - Vec3(-0.4, -0.15, 0)).norm(), 1e-15);
  EXPECT_LT((mesh.rest.col(4) - Vec3(0.4, -0.15, 0)).norm(), 1e-15);
  EXPECT_LT((mesh.rest.col(10) - Vec3(-0.4, 0.15, 0)).norm(), 1e-15);
  EXPECT_LT(mesh.rest.rowwise().sum().norm(), 1e-14);
}

TEST(Grid, FacesLookUpAndCoverTheArea) {
  const TriangleMesh mesh = make_grid(0.8, 0.3, 5, 4);
  double area = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 normal =
        Vec3(mesh.rest.col(t[1]) - mesh.rest.col(t[0])).cross(Vec3(mesh.rest.col(t[2]) - mesh.rest.col(t[0])));
    EXPECT_GT(normal.z(), 0.0);
    area += 0.5 * normal.z();
  }
  EXPECT_NEAR(area, 0.24, 1e-15);
  EXPECT_NO_THROW(check_mesh(mesh));
}

TEST(Grid, CutsNeighbouringCellsAlongDifferentDiagonals) {
  const TriangleMesh mesh = make_grid(1, 1, 2, 2);
  // Union jack: all four diagonals meet in the centre node 4, or none does.
  int at_centre = 0;
  for (const auto& e : edges_of(mesh)) {
    const bool diagonal = mesh.rest(0, e[0]) != mesh.rest(0, e[1]) && mesh.rest(1, e[0]) != mesh.rest(1, e[1]);
    if (diagonal && (e[0] == 4 || e[1] == 4)) ++at_centre;
  }
  EXPECT_TRUE(at_centre == 4 || at_centre == 0) << at_centre;
}

TEST(Grid, KeepsTheEulerCharacteristicOfADisc) {
  const TriangleMesh mesh = make_grid(1, 2, 7, 5);
  const auto edges = edges_of(mesh);
  EXPECT_EQ(
      mesh.rest.cols() - static_cast<Eigen::Index>(edges.size()) + static_cast<Eigen::Index>(mesh.triangles.size()), 1);
  // Every edge but the boundary's 2 (7 + 5) is a hinge.
  EXPECT_EQ(hinges_of(mesh).size(), edges.size() - 24);
}

TEST(Grid, RefusesEmptyAndInfiniteSizes) {
  EXPECT_THROW(make_grid(0, 1, 2, 2), InputError);
  EXPECT_THROW(make_grid(1, std::nan(""), 2, 2), InputError);
  EXPECT_THROW(make_grid(1, 1, 0, 2), InputError);
}

TEST(Hinges, NameTheEdgeAndBothOppositeNodes) {
  const auto hinges = hinges_of(square_of_two());
  ASSERT_EQ(hinges.size(), 1u);
  EXPECT_EQ(hinges[0], (std::array<int, 4>{0, 2, 1, 3}));
}

TEST(CheckMesh, NamesTheFaultyFaceOrEdge) {
  TriangleMesh mesh = square_of_two();
  EXPECT_NO_THROW(check_mesh(mesh));

  mesh.triangles[1] = {0, 2, 7};
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "vertex 7");
  mesh.triangles[1] = {0, 2, 2};
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "face 1 (0, 2, 2) repeats");
  mesh.triangles[1] = {0, 3, 2};
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "edge (0, 2): face 0");
  mesh.triangles = {{0, 1, 2}};
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "vertex 3 belongs to no face");

  mesh = square_of_two();
  mesh.rest.col(3) = 0.5 * (mesh.rest.col(0) + mesh.rest.col(2));
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "zero area");
  mesh.rest(1, 3) = std::nan("");
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "vertex 3 is not finite");

  mesh = square_of_two();
  mesh.rest.conservativeResize(3, 5);
  mesh.rest.col(4) = Vec3(0, 0, 1);
  mesh.triangles.push_back({2, 0, 4});
  EXPECT_MENTIONS(refusal_of([&] { check_mesh(mesh); }), "edge (0, 2) is shared by 3 faces");
}

TEST(Line, IsStraightAndCentred) {
  const Polyline line = make_line(2.0, 4);
  EXPECT_EQ(line.segment_count(), 4);
  EXPECT_LT((line.rest.col(0) - Vec3(-1, 0, 0)).norm(), 1e-15);
  EXPECT_LT((line.rest.col(4) - Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_THROW(make_line(1.0, 0), InputError);
  EXPECT_THROW(make_line(-1.0, 3), InputError);
}

TEST(Ring, HasThePerimeterAskedFor) {
  const Polyline ring = make_ring(3.0, 7);
  EXPECT_EQ(ring.segment_count(), 7);
  double perimeter = 0.0;
  for (int s = 0; s < 7; ++s) {
    const auto [a, b] = ring.segment(s);
    perimeter += (ring.rest.col(b) - ring.rest.col(a)).norm();
  }
  EXPECT_NEAR(perimeter, 3.0, 1e-14);
  EXPECT_THROW(make_ring(1.0, 2), InputError);
}

}  // namespace
}  // namespace deformable_sim
