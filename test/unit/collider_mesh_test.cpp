// Distances to meshes against brute force over all triangles, the planes that keep points out, and what is refused.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/surface_query.h"
#include "deformable_sim/core/error.h"
#include "support/collider_meshes.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

struct Case {
  const char* name;
  TriangleMesh (*mesh)();
  bool convex;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class ColliderMeshOf : public testing::TestWithParam<Case> {};

Vec3 random_vector(std::mt19937* random) {
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  return Vec3(in(*random), in(*random), in(*random));
}

Eigen::AlignedBox3d box_of(const TriangleMesh& mesh) {
  return Eigen::AlignedBox3d(Vec3(mesh.rest.rowwise().minCoeff()), Vec3(mesh.rest.rowwise().maxCoeff()));
}

/// All around, close to faces, and close to edges and corners, 1e-7 m to 1 cm away.
Vec3 sample(const TriangleMesh& mesh, int k, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Eigen::AlignedBox3d box = box_of(mesh);
  if (k % 3 == 0) return box.center() + 0.8 * box.sizes().maxCoeff() * random_vector(random);
  const std::array<Vec3, 3> x = test::corners_of(mesh, (*random)() % mesh.triangles.size());
  Vec3 weight(unit(*random), unit(*random), unit(*random));
  if (k % 3 == 2) weight[k % 2] = 0.0;
  if (k % 9 == 2) weight = Vec3::UnitX();
  weight /= weight.sum();
  return x[0] * weight[0] + x[1] * weight[1] + x[2] * weight[2] +
         std::pow(10.0, -2.0 - 5.0 * unit(*random)) * random_vector(random);
}

TEST_P(ColliderMeshOf, TellsTheDistanceOfTheNearestTriangle) {
  // |d| = min over triangles of the distance, d < 0 where the surface winds once around p; q = p - d n is on a
  // triangle.
  const TriangleMesh mesh = GetParam().mesh();
  const auto solids = make_collider_meshes(mesh);
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_EQ(solids[0]->convex(), GetParam().convex);
  std::mt19937 random(11);
  int inside = 0;
  for (int k = 0; k < 1500; ++k) {
    const Vec3 p = sample(mesh, k, &random);
    const double expected = test::brute_distance(p, mesh);
    MeshPoint found;
    ASSERT_TRUE(solids[0]->nearest(p, std::abs(expected) + 1e-9, &found));
    // Doubles of size 0.3 through a few products.
    EXPECT_NEAR(found.distance, expected, 1e-12);
    EXPECT_NEAR(found.normal.norm(), 1.0, 1e-9);
    EXPECT_LT(std::abs(test::brute_distance(p - found.distance * found.normal, mesh)), 1e-9);
    if (expected > 1e-9) {
      EXPECT_FALSE(solids[0]->nearest(p, expected - 1e-9, &found));
    }
    inside += expected < 0.0;
  }
  EXPECT_GT(inside, 100);
}

TEST_P(ColliderMeshOf, BoundsTheDistanceByItsGrid) {
  // d changes by the way gone at most: |d(p) - d(c)| <= |p - c| <= sqrt(3)/2 spacings, c the nearest grid point.
  const TriangleMesh mesh = GetParam().mesh();
  const auto solid = make_collider_meshes(mesh)[0];
  const DistanceGrid& grid = solid->grid();
  std::mt19937 random(12);
  double interpolated = 0.0;
  for (int k = 0; k < 1500; ++k) {
    const Vec3 p = sample(mesh, k, &random);
    DistanceBounds bounds;
    if (!grid.bounds(p, &bounds)) {
      EXPECT_FALSE(box_of(mesh).contains(p));
      continue;
    }
    const double expected = test::brute_distance(p, mesh);
    EXPECT_LE(bounds.low, expected);
    EXPECT_GE(bounds.high, expected);
    EXPECT_LT(bounds.high - bounds.low, 2.0 * 0.867 * grid.spacing() + 1e-6);

    const Vec3 at = (p - grid.origin()) / grid.spacing();
    const Eigen::Array3i cell = at.array().floor().cast<int>();
    if ((cell < 0).any() || (cell + 1 >= grid.size()).any()) continue;
    double value = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Array3i c = cell + Eigen::Array3i(corner & 1, (corner >> 1) & 1, corner >> 2);
      const Vec3 weight = Vec3::Ones() - (at - c.cast<double>().matrix()).cwiseAbs();
      value += weight.prod() * grid.value(c.x(), c.y(), c.z());
    }
    interpolated = std::max(interpolated, std::abs(value - expected));
  }
  // Interpolated linearly the same bound holds; sharp edges come close to it.
  EXPECT_LT(interpolated, 0.867 * grid.spacing());
  RecordProperty("grid_spacing_mm", std::to_string(1e3 * grid.spacing()));
  RecordProperty("largest_error_of_interpolated_grid_mm", std::to_string(1e3 * interpolated));
}

TEST_P(ColliderMeshOf, KeepsFastPointsOutByItsPlanes) {
  // p outside, q anywhere within reach and `clearance` above every plane of p: the way from p to q meets no triangle.
  const TriangleMesh mesh = GetParam().mesh();
  const auto solid = make_collider_meshes(mesh)[0];
  const double clearance = 0.0015;
  std::mt19937 random(13);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<TrianglePoint> work;
  int crossing = 0, admitted = 0, held = 0;
  for (int k = 0; k < 8000; ++k) {
    const Vec3 p = sample(mesh, k, &random);
    if (!box_of(mesh).contains(p) && k % 3 == 0) continue;
    const double reach = 0.05 * unit(random);
    MeshPoint surface;
    if (!solid->nearest(p, reach, &surface) || surface.distance <= 0.0) continue;
    std::vector<MeshPoint> planes;
    solid->planes(p, surface, reach, clearance, 0.0, &work, &planes);
    ASSERT_FALSE(planes.empty());
    for (size_t i = 0; i < planes.size(); ++i) {
      EXPECT_GE(planes[i].distance, surface.distance - 1e-12);
      for (const int v : solid->triangles()[static_cast<size_t>(planes[i].triangle)]) {
        const Vec3& vertex = solid->vertices()[static_cast<size_t>(v)];
        EXPECT_LT(planes[i].distance + planes[i].normal.dot(vertex - p), 1e-7) << "the triangle is below its plane";
      }
      if (i > 0) {
        EXPECT_GT(planes[i].triangle, planes[i - 1].triangle);
      }
    }
    // The plane of the nearest point is among them: what is below it holds the point.
    const Vec3 q = p + reach * unit(random) * random_vector(&random).normalized();
    bool above = true, held_by_one = false;
    for (const MeshPoint& plane : planes) {
      const bool over = plane.distance + plane.normal.dot(q - p) >= clearance;
      above = above && over;
      held_by_one = held_by_one || !over;
    }
    const bool through = test::crosses(p, q, mesh);
    crossing += through;
    admitted += above;
    held += held_by_one && through;
    if (above) {
      EXPECT_FALSE(through) << k << " from " << p.transpose() << " to " << q.transpose();
      EXPECT_GT(test::brute_distance(q, mesh), 0.0);
    }
  }
  EXPECT_GT(crossing, 100);
  EXPECT_EQ(held, crossing);
  EXPECT_GT(admitted, 100);
}

TEST_P(ColliderMeshOf, LeadsPointsInsideOut) {
  // A point inside that goes `clearance` above all its planes is outside.
  const TriangleMesh mesh = GetParam().mesh();
  const auto solid = make_collider_meshes(mesh)[0];
  std::mt19937 random(14);
  std::vector<TrianglePoint> work;
  for (int k = 0; k < 1500; ++k) {
    const Vec3 p = sample(mesh, k, &random);
    MeshPoint surface;
    if (!solid->nearest(p, 0.0, &surface) || surface.distance > -1e-6 || surface.distance < -0.002) continue;
    std::vector<MeshPoint> planes;
    solid->planes(p, surface, 0.002, 0.001, 0.0, &work, &planes);
    ASSERT_FALSE(planes.empty());
    Vec3 q = p;
    for (int round = 0; round < 500; ++round)
      for (const MeshPoint& plane : planes)
        q += std::max(0.0, 0.00101 - plane.distance - plane.normal.dot(q - p)) * plane.normal;
    for (const MeshPoint& plane : planes) ASSERT_GE(plane.distance + plane.normal.dot(q - p), 0.001);
    EXPECT_GT(test::brute_distance(q, mesh), 0.0) << k << " " << p.transpose();
  }
}

TEST_P(ColliderMeshOf, KeepsItsPaddingAsAShape) {
  // d of the padded shape = d - padding, in a frame of its own; a radius and a box that hold it.
  const TriangleMesh mesh = GetParam().mesh();
  Shape shape;
  shape.type = Shape::Type::kMesh;
  shape.mesh = make_collider_meshes(mesh)[0];
  shape.size[0] = 0.004;
  SurfaceQuery query(shape);
  EXPECT_EQ(query.concave_pieces(), GetParam().convex ? 0 : static_cast<int>(mesh.triangles.size()));
  std::mt19937 random(15);
  for (int k = 0; k < 300; ++k) {
    const Pose pose = test::at(0.3, -0.2, 0.1, 3.0 * random_vector(&random).x(), random_vector(&random));
    query.place(pose);
    const Vec3 local = sample(mesh, k, &random);
    const double expected = test::brute_distance(local, mesh) - 0.004;
    SurfacePoint found;
    ASSERT_TRUE(query.find(pose * local, std::abs(expected) + 1e-9, &found));
    EXPECT_NEAR(found.distance, expected, 1e-9);
    const Vec3 on_surface = pose * local - found.distance * found.normal;
    EXPECT_TRUE(query.box().contains(on_surface));
    EXPECT_LE((on_surface - pose.translation()).norm(), query.bounding_radius() + 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, ColliderMeshOf,
                         testing::Values(Case{"cube", [] { return test::box_mesh(0.2, 0.2, 0.2); }, true},
                                         Case{"plate", [] { return test::box_mesh(0.2, 0.15, 0.002); }, true},
                                         Case{"wedge", [] { return test::wedge_mesh(); }, true},
                                         Case{"l_body", [] { return test::l_mesh(); }, false},
                                         Case{"thin_channel", [] { return test::channel_mesh(); }, false},
                                         Case{"sphere", [] { return test::round_mesh(0.1, 12, 20); }, true},
                                         Case{"thin_bowl", [] { return test::round_mesh(0.1, 8, 20, 0.003); }, false}),
                         [](const auto& info) { return std::string(info.param.name); });

std::string refusal_of(const TriangleMesh& mesh) {
  try {
    make_collider_meshes(mesh);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SolidParts, AreTurnedOutwardsWhateverTheirWinding) {
  // Volume by the divergence theorem, sum a . (b x c) / 6, is that of the cube, however its triangles were wound.
  TriangleMesh mesh = test::box_mesh(1, 1, 1);
  for (size_t t : {0, 3, 4, 5, 9}) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  const std::vector<SolidPart> parts = split_into_solids(mesh);
  ASSERT_EQ(parts.size(), 1u);
  double volume = 0.0;
  for (const std::array<int, 3>& v : parts[0].triangles) {
    const auto x = [&](size_t k) { return parts[0].vertices[static_cast<size_t>(v[k])]; };
    volume += x(0).dot(x(1).cross(x(2))) / 6.0;
  }
  EXPECT_NEAR(volume, 1.0, 1e-12);
}

TEST(SolidParts, AreToldApartWhereOneVertexJoinsThem) {
  // Two cubes corner to corner, every triangle with vertices of its own as an STL file has them.
  const TriangleMesh cube = test::box_mesh(1, 1, 1);
  TriangleMesh soup;
  soup.rest.resize(3, 72);
  int n = 0;
  for (const double shift : {0.0, 1.0}) {
    for (size_t t = 0; t < cube.triangles.size(); ++t) {
      for (const Vec3& x : test::corners_of(cube, t)) soup.rest.col(n++) = x + Vec3::Constant(shift);
      soup.triangles.push_back({{n - 3, n - 2, n - 1}});
    }
  }
  const std::vector<SolidPart> parts = split_into_solids(soup);
  ASSERT_EQ(parts.size(), 2u);
  for (const SolidPart& part : parts) {
    EXPECT_EQ(part.vertices.size(), 8u);
    EXPECT_EQ(part.triangles.size(), 12u);
  }
}

TEST(SolidParts, AreMendedWhereATriangleHasNoArea) {
  // Vertex 8 halves the edge from 0 to 1 for the triangle below; one of no area closes the gap to the one beside.
  TriangleMesh mesh = test::box_mesh(1, 1, 1);
  mesh.rest.conservativeResize(3, 9);
  mesh.rest.col(8) = Vec3(0.5, 0, 0);
  ASSERT_EQ(mesh.triangles[0], (std::array<int, 3>{{0, 2, 1}}));
  mesh.triangles[0] = {{0, 2, 8}};
  mesh.triangles.push_back({{8, 2, 1}});
  mesh.triangles.push_back({{0, 8, 1}});
  const std::vector<SolidPart> parts = split_into_solids(mesh);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].vertices.size(), 9u);
  EXPECT_EQ(parts[0].triangles.size(), 14u);
  const ColliderMesh solid(parts[0]);
  EXPECT_TRUE(solid.convex());
  MeshPoint found;
  ASSERT_TRUE(solid.nearest(Vec3(0.4, -0.3, -0.4), 1.0, &found));
  EXPECT_NEAR(found.distance, 0.5, 1e-12);
  EXPECT_NEAR((found.normal - Vec3(0, -0.6, -0.8)).norm(), 0.0, 1e-12);
}

TEST(SolidParts, RefuseWhatIsNoSolid) {
  const TriangleMesh good = test::box_mesh(1, 1, 1);
  EXPECT_EQ(refusal_of(good), "");
  TriangleMesh bad = good;
  bad.triangles.pop_back();
  EXPECT_NE(refusal_of(bad).find("is not closed: the edge from (0 "), std::string::npos) << refusal_of(bad);
  bad = good;
  bad.triangles.clear();
  EXPECT_NE(refusal_of(bad).find("no triangles"), std::string::npos);
  bad = good;
  bad.triangles[4][1] = 8;
  EXPECT_NE(refusal_of(bad).find("triangle 4 names vertex 8 of 8"), std::string::npos);
  bad = good;
  bad.rest(1, 3) = std::nan("");
  EXPECT_NE(refusal_of(bad).find("vertex 3"), std::string::npos);
  bad = good;
  bad.triangles.push_back(good.triangles[0]);
  EXPECT_NE(refusal_of(bad).find("belongs to 3 triangles"), std::string::npos) << refusal_of(bad);
  bad.triangles = {{{0, 1, 2}}, {{0, 2, 1}}};
  EXPECT_NE(refusal_of(bad).find("encloses no volume"), std::string::npos) << refusal_of(bad);
  bad.triangles.assign(kMostColliderTriangles + 1, {{0, 1, 2}});
  EXPECT_NE(refusal_of(bad).find("at most 200000"), std::string::npos);
}

}  // namespace
}  // namespace deformable_sim
