// Volumes of tetrahedra: generators, boundary, masses, stresses at nodes, refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "deformable_sim/core/element/solid_stress.h"
#include "deformable_sim/core/error.h"
#include "support/solids.h"

namespace deformable_sim::test {
namespace {

double volume_of(const TetMesh& mesh) {
  double sum = 0.0;
  for (size_t t = 0; t < mesh.tets.size(); ++t) sum += deformable_sim::volume_of(mesh, t);
  return sum;
}

/// Volume enclosed by a closed surface, positive when its normals point outwards: sum of (a x b).c / 6.
double enclosed(const TriangleMesh& surface) {
  double sum = 0.0;
  for (const auto& t : surface.triangles) {
    sum += surface.rest.col(t[0]).cross(surface.rest.col(t[1])).dot(surface.rest.col(t[2])) / 6.0;
  }
  return sum;
}

/// The surface without the nodes inside.
TriangleMesh compact(const TriangleMesh& surface) {
  std::map<int, int> at;
  for (const auto& t : surface.triangles) {
    for (const int i : t) at.insert({i, 0});
  }
  TriangleMesh result;
  result.rest.resize(3, static_cast<Eigen::Index>(at.size()));
  int next = 0;
  for (auto& [node, column] : at) {
    column = next++;
    result.rest.col(column) = surface.rest.col(node);
  }
  for (const auto& t : surface.triangles) result.triangles.push_back({at[t[0]], at[t[1]], at[t[2]]});
  return result;
}

/// Closed, every edge with two faces that run along it in opposite directions.
void expect_closed(const TriangleMesh& surface) {
  const TriangleMesh used = compact(surface);
  EXPECT_NO_THROW(check_mesh(used));
  EXPECT_EQ(hinges_of(used).size(), edges_of(used).size());
}

/// Sphere of radius r around `center`: an octahedron, its faces cut in four `times` times.
TriangleMesh sphere(double r, const Vec3& center, int times) {
  TriangleMesh mesh;
  mesh.rest.resize(3, 6);
  mesh.rest << 1, -1, 0, 0, 0, 0, 0, 0, 1, -1, 0, 0, 0, 0, 0, 0, 1, -1;
  for (const int x : {0, 1}) {
    for (const int y : {2, 3}) {
      for (const int z : {4, 5}) {
        if ((x + y + z) % 2 == 0) {
          mesh.triangles.push_back({x, y, z});
        } else {
          mesh.triangles.push_back({x, z, y});
        }
      }
    }
  }
  for (int k = 0; k < times; ++k) {
    TriangleMesh fine;
    std::map<std::array<int, 2>, int> middle;
    std::vector<Vec3> points;
    for (Eigen::Index i = 0; i < mesh.rest.cols(); ++i) points.emplace_back(mesh.rest.col(i));
    const auto between = [&](int a, int b) {
      const auto [it, is_new] = middle.insert({{std::min(a, b), std::max(a, b)}, static_cast<int>(points.size())});
      if (is_new) points.push_back((mesh.rest.col(a) + mesh.rest.col(b)).normalized());
      return it->second;
    };
    for (const auto& t : mesh.triangles) {
      const int ab = between(t[0], t[1]), bc = between(t[1], t[2]), ca = between(t[2], t[0]);
      fine.triangles.insert(fine.triangles.end(), {{t[0], ab, ca}, {t[1], bc, ab}, {t[2], ca, bc}, {ab, bc, ca}});
    }
    fine.rest.resize(3, static_cast<Eigen::Index>(points.size()));
    for (size_t i = 0; i < points.size(); ++i) fine.rest.col(static_cast<Eigen::Index>(i)) = points[i];
    mesh = fine;
  }
  mesh.rest = (r * mesh.rest).colwise() + center;
  return mesh;
}

TEST(Box, IsCutIntoSixTetrahedraACell) {
  const Vec3 size(0.4, 0.3, 0.2);
  const TetMesh box = make_box(size, {4, 3, 2});
  EXPECT_NO_THROW(check_mesh(box));
  EXPECT_EQ(box.rest.cols(), 5 * 4 * 3);
  EXPECT_EQ(box.tets.size(), 6u * 24u);
  EXPECT_NEAR(volume_of(box), size.prod(), 1e-16);
  EXPECT_LT((box.rest.rowwise().maxCoeff() - 0.5 * size).norm(), 1e-15);
  EXPECT_LT((box.rest.rowwise().minCoeff() + 0.5 * size).norm(), 1e-15);
  // x fastest, then y, then z.
  EXPECT_LT((box.rest.col(1) - box.rest.col(0) - Vec3(0.1, 0, 0)).norm(), 1e-15);
  EXPECT_LT((box.rest.col(5) - box.rest.col(0) - Vec3(0, 0.1, 0)).norm(), 1e-15);
  EXPECT_LT((box.rest.col(20) - box.rest.col(0) - Vec3(0, 0, 0.1)).norm(), 1e-15);
}

TEST(Box, PrefersNoDirection) {
  // Mirrored from cell to cell: an even number of cells is its own mirror image in x, y and z.
  const TetMesh box = make_box(Vec3(1, 1, 1), {2, 2, 2});
  std::set<std::array<int, 4>> tets;
  for (auto t : box.tets) {
    std::sort(t.begin(), t.end());
    tets.insert(t);
  }
  const std::array<std::function<int(int)>, 3> mirror = {[](int i) { return i / 3 * 3 + 2 - i % 3; },
                                                         [](int i) { return i / 9 * 9 + (2 - i / 3 % 3) * 3 + i % 3; },
                                                         [](int i) { return (2 - i / 9) * 9 + i % 9; }};
  for (const auto& m : mirror) {
    for (auto t : tets) {
      for (int& i : t) i = m(i);
      std::sort(t.begin(), t.end());
      EXPECT_EQ(tets.count(t), 1u);
    }
  }
}

TEST(Box, RefusesWhatIsNoBox) {
  EXPECT_THROW(make_box(Vec3(1, 0, 1), {1, 1, 1}), InputError);
  EXPECT_THROW(make_box(Vec3(1, std::nan(""), 1), {1, 1, 1}), InputError);
  EXPECT_THROW(make_box(Vec3(1, 1, 1), {1, 0, 1}), InputError);
  EXPECT_THROW(make_box(Vec3(1, 1, 1), {1000, 1000, 1000}), InputError);
}

TEST(MidNodes, LieInTheMiddleOfEveryEdgeOnce) {
  // Euler: a box of one cell has 8 corners, 12 edges, 6 face diagonals and one inside.
  const TetMesh box = with_mid_nodes(make_box(Vec3(1, 2, 3), {1, 1, 1}));
  EXPECT_EQ(box.rest.cols(), 8 + 12 + 6 + 1);
  EXPECT_NO_THROW(check_mesh(box));
  EXPECT_NO_THROW(check_mesh(with_mid_nodes(make_irregular_box(Vec3(1, 1, 1), {3, 3, 3}, 1))));
}

TEST(Boundary, IsClosedAndFacesOutwards) {
  const Vec3 size(0.4, 0.3, 0.2);
  const TetMesh box = make_box(size, {3, 2, 2});
  const TriangleMesh surface = boundary_of(box);
  EXPECT_EQ(surface.triangles.size(), 2u * 2u * (3 * 2 + 3 * 2 + 2 * 2));
  EXPECT_EQ(surface.rest, box.rest);
  EXPECT_NEAR(enclosed(surface), size.prod(), 1e-16);
  expect_closed(surface);

  const TetMesh quadratic = with_mid_nodes(box);
  const TriangleMesh fine = boundary_of(quadratic);
  EXPECT_EQ(fine.triangles.size(), 4 * surface.triangles.size());
  EXPECT_NEAR(enclosed(fine), size.prod(), 1e-16);
  expect_closed(fine);
  std::set<int> used;
  for (const auto& t : fine.triangles) used.insert(t.begin(), t.end());
  for (int i = 0; i < quadratic.rest.cols(); ++i) {
    EXPECT_EQ(used.count(i) == 1, on_surface(size, quadratic.rest.col(i))) << i;
  }
}

TEST(Boundary, OfOneTetrahedronIsAllItsFaces) {
  // Each normal points away from the corner that is not in the face, for all four of them, whole and cut in four.
  TetMesh one;
  one.rest.resize(3, 4);
  one.rest << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  one.tets = {{0, 1, 2, 3}};
  for (const TetMesh& mesh : {one, with_mid_nodes(one)}) {
    const TriangleMesh surface = boundary_of(mesh);
    EXPECT_EQ(surface.triangles.size(), mesh.is_quadratic() ? 16u : 4u);
    for (const auto& t : surface.triangles) {
      const Vec3 a = surface.rest.col(t[0]), b = surface.rest.col(t[1]), c = surface.rest.col(t[2]);
      EXPECT_GT((b - a).cross(c - a).dot(a - Vec3::Constant(0.25)), 0.0) << t[0] << " " << t[1] << " " << t[2];
    }
    expect_closed(surface);
  }
}

TEST(Lattice, FillsABoxExactly) {
  // A surface in the faces of the cells: no cell more, none less.
  const TriangleMesh surface = compact(boundary_of(make_box(Vec3(0.4, 0.3, 0.2), {2, 2, 2})));
  const TetMesh lattice = make_lattice_around(surface, 0.1);
  EXPECT_EQ(lattice.tets.size(), 6u * 24u);
  EXPECT_NEAR(volume_of(lattice), 0.4 * 0.3 * 0.2, 1e-15);
}

TEST(Lattice, CoversASphereWithinACell) {
  // Every cell touches the ball: pi/6 d^3 < volume < pi/6 (d + 2 sqrt(3) a)^3.
  const Vec3 center(0.3, -0.2, 0.1);
  const TriangleMesh surface = sphere(0.5, center, 3);
  for (const double cell : {0.3, 0.1, 0.06}) {
    const TetMesh lattice = make_lattice_around(surface, cell);
    EXPECT_NO_THROW(check_mesh(lattice));
    expect_closed(boundary_of(lattice));
    EXPECT_GT(volume_of(lattice), enclosed(surface) - 1e-12);
    EXPECT_LT(volume_of(lattice), M_PI / 6.0 * std::pow(1.0 + 2.0 * std::sqrt(3.0) * cell, 3));
    for (Eigen::Index i = 0; i < lattice.rest.cols(); ++i) {
      EXPECT_LT((lattice.rest.col(i) - center).norm(), 0.5 + std::sqrt(3.0) * cell);
    }
  }
}

TEST(Lattice, LeavesACavityEmpty) {
  // An inner sphere wound the other way round encloses what is outside the body.
  TriangleMesh shell = sphere(0.5, Vec3::Zero(), 3);
  const TriangleMesh hole = sphere(0.35, Vec3::Zero(), 3);
  const int n = static_cast<int>(shell.rest.cols());
  Nodes rest(3, n + hole.rest.cols());
  rest << shell.rest, hole.rest;
  shell.rest = rest;
  for (const auto& t : hole.triangles) shell.triangles.push_back({n + t[0], n + t[2], n + t[1]});
  const TetMesh lattice = make_lattice_around(shell, 0.05);
  expect_closed(boundary_of(lattice));
  for (size_t t = 0; t < lattice.tets.size(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (const int i : lattice.tets[t]) middle += 0.25 * lattice.rest.col(i);
    EXPECT_GT(middle.norm(), 0.35 - 0.09);
  }
}

TEST(Lattice, JoinsWhatTouchesAtAnEdgeOnly) {
  // Two boxes that meet at an edge: filled in, so that the surface is a manifold.
  TriangleMesh surface = compact(boundary_of(make_box(Vec3(0.2, 0.2, 0.2), {1, 1, 1})));
  TriangleMesh other = surface;
  surface.rest.colwise() += Vec3(-0.1, -0.1, 0.0);
  other.rest.colwise() += Vec3(0.1, 0.1, 0.0);
  Nodes rest(3, 16);
  rest << surface.rest, other.rest;
  surface.rest = rest;
  for (const auto& t : other.triangles) surface.triangles.push_back({8 + t[0], 8 + t[1], 8 + t[2]});
  const TetMesh lattice = make_lattice_around(surface, 0.2);
  EXPECT_NO_THROW(check_mesh(lattice));
  EXPECT_EQ(lattice.tets.size(), 6u * 4u);  // the two cubes and the two that fill the block
  expect_closed(boundary_of(lattice));
}

TEST(Lattice, RefusesAnOpenSurfaceAndBadCells) {
  TriangleMesh surface = sphere(0.5, Vec3::Zero(), 1);
  EXPECT_THROW(make_lattice_around(surface, 0.0), InputError);
  EXPECT_THROW(make_lattice_around(surface, std::nan("")), InputError);
  EXPECT_THROW(make_lattice_around(surface, 1e-6), InputError);
  surface.triangles.pop_back();
  EXPECT_THROW(make_lattice_around(surface, 0.1), InputError);
}

/// The message with which a changed mesh is refused.
std::string refusal(bool quadratic, const std::function<void(TetMesh*)>& change) {
  TetMesh mesh = make_box(Vec3(1, 1, 1), {2, 1, 1});
  if (quadratic) mesh = with_mid_nodes(mesh);
  change(&mesh);
  try {
    check_mesh(mesh);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(TetMeshes, AreRefusedWithTheOffendingElement) {
  const auto says = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  says(refusal(false, [](TetMesh* m) { m->tets.clear(); }), "no tetrahedron");
  says(refusal(false, [](TetMesh* m) { m->rest(1, 3) = std::nan(""); }), "node 3 is not finite");
  says(refusal(false, [](TetMesh* m) { m->tets[4][2] = 99; }), "tetrahedron 4");
  says(refusal(false, [](TetMesh* m) { m->tets[4][2] = m->tets[4][1]; }), "repeats node");
  says(refusal(false, [](TetMesh* m) { std::swap(m->tets[5][0], m->tets[5][1]); }), "tetrahedron 5");
  says(refusal(false, [](TetMesh* m) { std::swap(m->tets[5][0], m->tets[5][1]); }), "inside out");
  says(refusal(false,
               [](TetMesh* m) {
                 const auto t = m->tets[2];
                 m->rest.col(t[3]) = (m->rest.col(t[0]) + m->rest.col(t[1]) + m->rest.col(t[2])) / 3.0;
               }),
       "tetrahedron");
  says(refusal(false,
               [](TetMesh* m) { m->rest.conservativeResize(3, m->rest.cols() + 1), m->rest.rightCols(1).setZero(); }),
       "belongs to no tetrahedron");
  says(refusal(false, [](TetMesh* m) { m->tets.push_back(m->tets[0]); }), "the same side of their common face");
  says(refusal(true, [](TetMesh* m) { m->rest(0, m->rest.cols() - 1) += 0.1; }), "in the middle of nodes");
  says(refusal(true, [](TetMesh* m) { m->mid_nodes.pop_back(); }), "all need them, or none");
}

TEST(TetMeshes, MayHaveSliversAThousandTimesAsLongAsThick) {
  TetMesh mesh;
  mesh.rest.resize(3, 4);
  mesh.rest << 0, 1, 0.5, 0.5, 0, 0, 1e-3, 0, 0, 0, 0, 1e-3;
  mesh.tets = {{0, 1, 2, 3}};
  EXPECT_NO_THROW(check_mesh(mesh));
}

TEST(SolidMasses, AddUpToTheBody) {
  // sum m = rho V; centre and second moments by the consistent matrix: integral of rho x x exactly.
  const Vec3 size(0.4, 0.3, 0.2);
  const double density = 900.0, total = density * size.prod();
  for (const bool quadratic : {false, true}) {
    TetMesh mesh = make_irregular_box(size, {3, 3, 3}, 3);
    if (quadratic) mesh = with_mid_nodes(mesh);
    const Eigen::VectorXd lumped = solid_masses(mesh, density);
    EXPECT_GT(lumped.minCoeff(), 0.0);
    EXPECT_NEAR(lumped.sum(), total, 1e-12 * total);
    const Eigen::SparseMatrix<double> matrix = solid_mass_matrix(mesh, density);
    EXPECT_NEAR(matrix.sum(), total, 1e-12 * total);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd x = mesh.rest.row(axis).transpose();
      EXPECT_NEAR(x.dot(matrix * x), total * size[axis] * size[axis] / 12.0, 1e-12 * total);
      if (!quadratic) continue;  // x^2 is in the quadratic space: integral of x^4
      const Eigen::VectorXd squared = x.cwiseAbs2();
      EXPECT_NEAR(squared.dot(matrix * squared), total * std::pow(size[axis], 4) / 80.0, 1e-12 * total);
    }
    const Eigen::VectorXd diagonal = matrix.diagonal();
    if (!quadratic) EXPECT_LT((lumped - 2.5 * diagonal).norm(), 1e-12 * total);
  }
  // Of one quadratic element the lumped masses are in the ratio of the diagonal.
  TetMesh one;
  one.rest.resize(3, 4);
  one.rest << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  one.tets = {{0, 1, 2, 3}};
  one = with_mid_nodes(one);
  const Eigen::VectorXd diagonal = solid_mass_matrix(one, 6.0).diagonal();
  EXPECT_LT((solid_masses(one, 6.0) - diagonal / diagonal.sum()).norm(), 1e-15);
}

TEST(SolidStress, IsTheConstantStressOfAHomogeneousDeformation) {
  // x = F X: every node of every mesh has the Cauchy stress of F, every element the deformation gradient F.
  const SolidMaterial material = solid_material(SolidLaw::kNeoHookean, 2e4, 0.3);
  std::mt19937 generator(8);
  const Mat3 f = with_stretches(Vec3(1.3, 1.1, 0.8), &generator);
  for (const bool quadratic : {false, true}) {
    TetMesh mesh = make_irregular_box(Vec3(1, 1, 1), {3, 3, 3}, 4);
    if (quadratic) mesh = with_mid_nodes(mesh);
    const Nodes x = (f * mesh.rest).colwise() + Vec3(1, 2, 3);
    const Mat3 expected = cauchy_stress(material, f);
    for (const Mat3& stress : solid_cauchy_stress(mesh, material, x)) {
      EXPECT_LT((stress - expected).norm(), 1e-12 * 2e4);
    }
    for (const Mat3& gradient : deformation_gradients(mesh, x)) EXPECT_LT((gradient - f).norm(), 1e-13);
    const Eigen::VectorXf mises = solid_stress(mesh, material, x);
    EXPECT_EQ(mises.size(), mesh.rest.cols());
    EXPECT_NEAR(mises[0], von_mises(expected), 1e-6 * von_mises(expected));
  }
}

TEST(SolidStress, IsLinearInsideQuadraticElements) {
  // Bending u = (x z, 0, -x^2 / 2) / R: F_xx = 1 + z / R, P_xx = (lambda + 2 mu) z / R by Hooke's law, exact at all
  // nodes.
  const SolidMaterial material = solid_material(SolidLaw::kHooke, 1.0, 0.0);
  const TetMesh mesh = with_mid_nodes(make_irregular_box(Vec3(1, 1, 1), {2, 2, 2}, 5));
  const double curvature = 1e-2;
  Nodes x = mesh.rest;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const Vec3 p = mesh.rest.col(i);
    x.col(i) += curvature * Vec3(p.x() * p.z(), 0.0, -0.5 * p.x() * p.x());
  }
  const std::vector<Mat3> stress = solid_cauchy_stress(mesh, material, x);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    EXPECT_NEAR(stress[static_cast<size_t>(i)](0, 0), curvature * mesh.rest(2, i), 1e-14);
    EXPECT_NEAR(stress[static_cast<size_t>(i)](0, 2), 0.0, 1e-14);
  }
}

}  // namespace
}  // namespace deformable_sim::test
