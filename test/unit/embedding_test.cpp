// Surfaces carried by coarser meshes: exact for affine motions, continuous, outside too.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>

#include <Eigen/LU>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/box_tree.h"
#include "deformable_sim/core/topology/skin.h"

namespace deformable_sim {
namespace {

constexpr double kExact = 1e-12;

/// The unit cube from the origin, of n^3 cells.
TetMesh cube(int n) {
  TetMesh mesh = make_box(Vec3::Ones(), {n, n, n});
  mesh.rest.array() += 0.5;
  return mesh;
}

/// Points in the cube of edge 2 `reach` around the centre of the unit cube.
Nodes points_around(int count, double reach, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.5 - reach, 0.5 + reach);
  Nodes points(3, count);
  for (int i = 0; i < count; ++i) points.col(i) = Vec3(uniform(random), uniform(random), uniform(random));
  return points;
}

TriangleMesh surface_of(const Nodes& points) {
  TriangleMesh surface;
  surface.rest = points;
  surface.triangles = {{0, 1, 2}};
  return surface;
}

/// A bent sheet: a quarter of a cylinder of radius 1 about y.
TriangleMesh bent_sheet(int cells) {
  TriangleMesh sheet = make_grid(M_PI / 2, 1.0, cells, cells);
  for (int i = 0; i < sheet.rest.cols(); ++i) {
    const double angle = sheet.rest(0, i);
    sheet.rest.col(i) = Vec3(std::sin(angle), sheet.rest(1, i), std::cos(angle));
  }
  return sheet;
}

/// Hills and hollows of 5 cm, about as curved as a hand.
TriangleMesh hillocks() {
  TriangleMesh sheet = make_grid(1.0, 1.0, 9, 9);
  for (int i = 0; i < sheet.rest.cols(); ++i) {
    sheet.rest(2, i) = 0.05 * std::sin(7.0 * sheet.rest(0, i)) * std::cos(5.0 * sheet.rest(1, i));
  }
  return sheet;
}

TEST(EmbeddingInTetrahedra, IsExactForAffineMotions) {
  // sum w_i = 1 and sum w_i x_i = p, so y(A x + b) = A p + b; inside, outside, linear, quadratic.
  const Mat3 a = 2.0 * Mat3::Random();
  const Vec3 b = Vec3::Random();
  for (const TetMesh& mesh : {cube(3), with_mid_nodes(cube(3))}) {
    for (const double reach : {0.5, 1.0}) {
      const Nodes points = points_around(400, reach, 1);
      const Nodes moved = ((a * mesh.rest).colwise() + b) * embed_in_volume(points, mesh).weights;
      EXPECT_LT((moved - ((a * points).colwise() + b)).cwiseAbs().maxCoeff(), kExact) << reach;
    }
  }
}

TEST(EmbeddingInTetrahedra, TakesInsidePointsFromTheCornersAroundThem) {
  // Barycentric coordinates of an inside point are in [0, 1], of four corners.
  const Embedding embedding = embed_in_volume(points_around(300, 0.5, 2), cube(4));
  for (int p = 0; p < embedding.weights.outerSize(); ++p) {
    int corners = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator i(embedding.weights, p); i; ++i, ++corners) {
      EXPECT_GE(i.value(), -kExact);
      EXPECT_LE(i.value(), 1.0 + kExact);
    }
    EXPECT_EQ(corners, 4);
  }
}

TEST(EmbeddingInTetrahedra, ReproducesQuadraticMotionsWithQuadraticShapeFunctions) {
  // The ten shape functions span all polynomials of degree 2.
  const auto motion = [](const Vec3& p) {
    return Vec3(p.x() + 0.3 * p.y() * p.y(), p.y() - p.x() * p.z(), p.z() + p.x() * p.x() - 0.5 * p.y() * p.z());
  };
  const TetMesh mesh = with_mid_nodes(cube(2));
  const Nodes points = points_around(300, 0.5, 3);
  Nodes x = mesh.rest;
  for (int i = 0; i < x.cols(); ++i) x.col(i) = motion(mesh.rest.col(i));
  const Nodes moved = x * embed_in_volume(points, mesh).weights;
  for (int p = 0; p < points.cols(); ++p) EXPECT_LT((moved.col(p) - motion(points.col(p))).norm(), kExact);
}

TEST(EmbeddingInTetrahedra, PutsAPointOnANodeExactlyThere) {
  for (const TetMesh& mesh : {cube(2), with_mid_nodes(cube(2))}) {
    const Nodes x = Nodes::Random(3, mesh.rest.cols());
    const Nodes corners = mesh.rest.leftCols(27);
    EXPECT_LT((x * embed_in_volume(corners, mesh).weights - x.leftCols(27)).cwiseAbs().maxCoeff(), kExact);
  }
}

TEST(EmbeddingInTetrahedra, IsContinuousInside) {
  // |y(p) - y(q)| <= L |p - q| with L the largest deformation gradient, whatever lies between p and q.
  const TetMesh mesh = cube(3);
  const Nodes x = mesh.rest + 0.05 * Nodes::Random(3, mesh.rest.cols());
  const int steps = 20000;
  Nodes line(3, steps + 1);
  for (int i = 0; i <= steps; ++i) {
    line.col(i) = Vec3(0.02, 0.11, 0.03) + (0.95 * i / steps) * Vec3(1.0, 0.77, 0.91);
  }
  const Nodes moved = x * embed_in_volume(line, mesh).weights;
  const double step = (line.col(1) - line.col(0)).norm();
  for (int i = 0; i < steps; ++i) EXPECT_LT((moved.col(i + 1) - moved.col(i)).norm(), 3.0 * step) << i;
}

TEST(EmbeddingInTetrahedra, ExtrapolatesOutsideFromTheNearestPoint) {
  // y(p) = y(c) + (dy/dp)(c) (p - c) with c the nearest point of the mesh, off faces, edges and corners alike.
  const auto motion = [](const Vec3& p) {
    return Vec3(p.x() + 0.3 * p.y() * p.y(), p.y() - p.x() * p.z(), p.z() + 0.5 * p.z() * p.z());
  };
  const auto gradient = [](const Vec3& p) {
    return (Mat3() << 1.0, 0.6 * p.y(), 0.0, -p.z(), 1.0, -p.x(), 0.0, 0.0, 1.0 + p.z()).finished();
  };
  const TetMesh mesh = with_mid_nodes(cube(2));
  Nodes x = mesh.rest;
  for (int i = 0; i < x.cols(); ++i) x.col(i) = motion(mesh.rest.col(i));
  const Nodes points = points_around(500, 1.2, 10);
  const Nodes moved = x * embed_in_volume(points, mesh).weights;
  for (int i = 0; i < points.cols(); ++i) {
    const Vec3 p = points.col(i), c = p.cwiseMax(0.0).cwiseMin(1.0);
    EXPECT_LT((moved.col(i) - motion(c) - gradient(c) * (p - c)).norm(), kExact) << p.transpose();
  }
}

TEST(EmbeddingInTetrahedra, OfEquallyNearOnesPicksTheLeastOutside) {
  // Beyond the corner (1, 1, 1) all six tetrahedra around the diagonal are equally near; chosen is the one whose
  // smallest coordinate is largest.
  const TetMesh mesh = cube(1);
  std::array<double, 3> steps{{0.075, 0.15, 0.3}};
  do {
    const Vec3 point = Vec3::Ones() + Vec3(steps[0], steps[1], steps[2]);
    double expected = -1e9;
    for (const auto& tet : mesh.tets) {
      Eigen::Matrix4d corners = Eigen::Matrix4d::Ones();
      for (int k = 0; k < 4; ++k) corners.col(k).head<3>() = mesh.rest.col(tet[static_cast<size_t>(k)]);
      expected = std::max(expected, (corners.inverse() * point.homogeneous()).minCoeff());
    }
    const Eigen::VectorXd weights = embed_in_volume(point, mesh).weights;
    EXPECT_NEAR(weights.minCoeff(), expected, kExact);
  } while (std::next_permutation(steps.begin(), steps.end()));
}

TEST(EmbeddingInTetrahedra, RefusesWhatCannotCarry) {
  EXPECT_THROW(embed_in_volume(Nodes::Zero(3, 1), TetMesh()), InputError);
  EXPECT_THROW(embed_in_volume(Nodes::Constant(3, 1, std::nan("")), cube(1)), InputError);
  TetMesh flat = cube(1);
  flat.rest.row(2).setZero();
  EXPECT_THROW(embed_in_volume(Nodes::Zero(3, 1), flat), InputError);
}

TEST(EmbeddingInASheet, StaysWhereItIsAtRest) {
  // sum w_i (x_i + h n_i) = p at rest, on, above and below a bent sheet, and beyond its rim.
  const auto sheet = std::make_shared<TriangleMesh>(bent_sheet(6));
  Nodes points(3, 400);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> angle(-0.85, 0.85), along(-0.6, 0.6), radius(0.75, 1.3);
  for (int p = 0; p < points.cols(); ++p) {
    const double a = angle(random), r = radius(random);
    points.col(p) = Vec3(r * std::sin(a), along(random), r * std::cos(a));
  }
  const auto skin = make_skin(surface_of(points), sheet);
  EXPECT_LT((skin->positions(sheet->rest) - points).cwiseAbs().maxCoeff(), kExact);
}

TEST(EmbeddingInASheet, StaysWhereItIsAboveAHillockyOne) {
  // Curved both ways, the height is the root of a full cubic.
  const auto sheet = std::make_shared<TriangleMesh>(hillocks());
  Nodes points = make_grid(0.9, 0.9, 20, 20).rest;
  for (int p = 0; p < points.cols(); ++p) points(2, p) = 0.12 * std::sin(40.0 * p);
  EXPECT_LT((make_skin(surface_of(points), sheet)->positions(sheet->rest) - points).cwiseAbs().maxCoeff(), kExact);
}

TEST(EmbeddingInASheet, IsExactForRigidMotions) {
  // Normals turn with the sheet: y(R x + b) = R p + b.
  const auto sheet = std::make_shared<TriangleMesh>(bent_sheet(5));
  Nodes points = sheet->rest;
  points.array() *= 1.1;
  const auto skin = make_skin(surface_of(points), sheet);
  const Mat3 r = Eigen::AngleAxisd(1.3, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
  const Vec3 b(0.3, -2.0, 5.0);
  EXPECT_LT((skin->positions((r * sheet->rest).colwise() + b) - ((r * points).colwise() + b)).cwiseAbs().maxCoeff(),
            kExact);
}

TEST(EmbeddingInASheet, IsExactForAffineMotionsOnTheSheet) {
  // Without height only the barycentric weights are left; inside and, extrapolated, beyond the rim.
  const auto sheet = std::make_shared<TriangleMesh>(make_grid(1, 1, 4, 3));
  Nodes points = points_around(200, 0.6, 5);
  points.row(2).setZero();
  points.topRows(2).array() -= 0.5;
  const auto skin = make_skin(surface_of(points), sheet);
  const Mat3 a = Mat3::Random();
  EXPECT_LT((skin->positions(a * sheet->rest) - a * points).cwiseAbs().maxCoeff(), kExact);
}

TEST(EmbeddingInASheet, KeepsHeightsAboveABentSheet) {
  // A flat layer 0.02 above a flat sheet becomes one 0.02 above the cylinder it is bent to: radius 1.02. The faces'
  // chords and mean normals are off by O(cell^2): 1 - cos(0.5 pi / 2 / 32) = 3e-4.
  const auto flat = std::make_shared<TriangleMesh>(make_grid(M_PI / 2, 1.0, 32, 8));
  Nodes points = make_grid(1.4, 0.9, 50, 20).rest;
  points.row(2).setConstant(0.02);
  Nodes bent = flat->rest;
  for (int i = 0; i < bent.cols(); ++i) {
    bent.col(i) = Vec3(std::sin(flat->rest(0, i)), flat->rest(1, i), std::cos(flat->rest(0, i)));
  }
  const Nodes layer = make_skin(surface_of(points), flat)->positions(bent);
  for (int p = 0; p < layer.cols(); ++p) {
    EXPECT_NEAR(std::hypot(layer(0, p), layer(2, p)), 1.02, 4e-4) << p;
    EXPECT_NEAR(layer(1, p), points(1, p), 1e-9);
  }
}

TEST(EmbeddingInASheet, IsContinuousAboveIt) {
  // Neighbouring triangles share the corners that they move along normals: no jump where a line above the sheet passes
  // from one to the next, though their normals differ. The bound is a Lipschitz constant, as above.
  const auto sheet = std::make_shared<TriangleMesh>(hillocks());
  const int steps = 20000;
  Nodes line(3, steps + 1);
  for (int i = 0; i <= steps; ++i) {
    const Vec3 p = Vec3(-0.45, -0.42, 0.0) + (0.9 * i / steps) * Vec3(1.0, 0.9, 0.0);
    line.col(i) = p + Vec3(0, 0, 0.05 * std::sin(7.0 * p.x()) * std::cos(5.0 * p.y()) + 0.06);
  }
  Nodes x = sheet->rest;
  x.row(2) += 0.04 * Eigen::RowVectorXd::Random(x.cols());
  const Nodes moved = make_skin(surface_of(line), sheet)->positions(x);
  const double step = (line.col(1) - line.col(0)).norm();
  for (int i = 0; i < steps; ++i) EXPECT_LT((moved.col(i + 1) - moved.col(i)).norm(), 5.0 * step) << i;
}

TEST(EmbeddingInASheet, ExtrapolatesBeyondItsRimFromTheTriangleThere) {
  // 0.1 beyond the middle of a side of a triangle in cells of 0.25: the corner opposite to that side has -0.1 / 0.25.
  for (const double height : {0.0, 0.05}) {
    const Eigen::VectorXd weights = embed_in_sheet(Vec3(0.6, 0.125, height), make_grid(1.0, 1.0, 4, 4)).weights;
    EXPECT_NEAR(weights.minCoeff(), -0.4, kExact);
  }
}

TEST(EmbeddingInASheet, RefusesAPointBeyondItsFocus) {
  const TriangleMesh sheet = bent_sheet(6);
  try {
    embed_in_sheet(Vec3(0.0, 0.0, -3.0), sheet);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("surface vertex 0"), std::string::npos) << error.what();
  }
}

TEST(Skin, HasTheVelocityOfItsVertices) {
  // dy/dt by central differences along x + t v: error O(t^2), far below 1e-7 at t = 1e-5.
  const auto sheet = std::make_shared<TriangleMesh>(bent_sheet(4));
  const TetMesh volume = cube(2);
  const double t = 1e-5;
  const auto on_sheet = make_skin(surface_of(1.07 * sheet->rest), sheet);
  const auto in_volume = make_skin(surface_of(points_around(50, 0.6, 6)), volume);
  for (const auto& [skin, rest] : {std::pair(on_sheet, sheet->rest), std::pair(in_volume, volume.rest)}) {
    const Nodes x = rest + 0.03 * Nodes::Random(3, rest.cols()), v = Nodes::Random(3, rest.cols());
    const Nodes expected = (skin->positions(x + t * v) - skin->positions(x - t * v)) / (2.0 * t);
    EXPECT_LT((skin->velocities(x, v) - expected).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(Skin, NamesTheNearestNodeOfEachVertex) {
  const TetMesh mesh = cube(3);
  const Nodes points = points_around(200, 0.8, 7);
  const auto skin = make_skin(surface_of(points), mesh);
  for (int p = 0; p < points.cols(); ++p) {
    const double nearest = (mesh.rest.colwise() - points.col(p)).colwise().norm().minCoeff();
    const int node = skin->nearest_node()[static_cast<size_t>(p)];
    EXPECT_NEAR((mesh.rest.col(node) - points.col(p)).norm(), nearest, 1e-15);
  }
}

TEST(BoxTree, FindsWhatASearchThroughAllFinds) {
  const Nodes at = points_around(500, 1.0, 8), asked = points_around(100, 1.5, 9);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < at.cols(); ++i) boxes.emplace_back(Vec3(at.col(i)));
  const BoxTree tree(boxes);
  for (int p = 0; p < asked.cols(); ++p) {
    const Vec3 point = asked.col(p);
    const auto distances = (at.colwise() - point).colwise().squaredNorm().eval();
    int asked_for = 0;
    const auto nearest = tree.nearest(point, [&](int i) {
      ++asked_for;
      return distances[i];
    });
    EXPECT_EQ(nearest.first, distances.minCoeff());
    EXPECT_LT(asked_for, 100);
    int within = 0;
    tree.visit_within(point, 0.3, [&](int i) { within += distances[i] <= 0.3 ? 1 : 0; });
    EXPECT_EQ(within, (distances.array() <= 0.3).count());
  }
}

}  // namespace
}  // namespace deformable_sim
