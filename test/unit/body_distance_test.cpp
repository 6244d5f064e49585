// The distance of a body to colliders: closed forms, samples all over the body, and solids put together of boxes.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/contact/body_distance.h"
#include "deformable_sim/core/contact/surface_query.h"
#include "support/collider_meshes.h"
#include "support/small_worlds.h"
#include "support/voxels.h"

namespace deformable_sim {
namespace {

constexpr double kRadius = 0.001;

std::shared_ptr<Model> sheet(double size, int cells) {
  test::Sheet s;
  s.size_x = s.size_y = size;
  s.cells_x = s.cells_y = cells;
  s.contact_radius = kRadius;
  return test::sheet_model(s);
}

Vec3 random_vector(std::mt19937* random) {
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  return Vec3(in(*random), in(*random), in(*random));
}

/// Least signed distance of points all over the triangles, k/60 of the way from corner to corner, less the radius.
double sampled(const Model& model, const Nodes& x, const std::vector<Collider>& colliders) {
  double least = 1e9;
  for (const Collider& collider : colliders) {
    for (const Shape& shape : collider.shapes) {
      SurfaceQuery query(shape);
      query.place(collider.world_from_collider * shape.collider_from_shape);
      for (const auto& t : model.bodies[0].surface->triangles) {
        for (int i = 0; i <= 60; ++i) {
          for (int j = 0; i + j <= 60; ++j) {
            const Vec3 p = (i * x.col(t[0]) + j * x.col(t[1]) + (60 - i - j) * x.col(t[2])) / 60.0;
            SurfacePoint found;
            if (query.find(p, 10.0, &found)) least = std::min(least, found.distance - kRadius);
          }
        }
      }
    }
  }
  return least;
}

struct Case {
  const char* name;
  Shape::Type type;
  Vec3 size;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class DistanceTo : public testing::TestWithParam<Case> {};

TEST_P(DistanceTo, IsTheLeastOverTheWholeSheet) {
  // No sample is nearer; the nearest sample is no further than a step of the samples. The two points are that far
  // apart, and the one on the collider is on its surface.
  const auto model = sheet(0.1, 3);
  std::mt19937 random(41);
  int apart = 0, deep = 0;
  for (int k = 0; k < 60; ++k) {
    const Pose pose = test::at(0, 0, 0, 3.0 * random_vector(&random).x(), random_vector(&random));
    Collider c = test::collider("c", GetParam().type, GetParam().size, pose);
    c.world_from_collider.translation() = 0.12 * random_vector(&random);
    Nodes x = model->initial.x;
    for (int i = 0; i < x.cols(); ++i) x.col(i) += 0.02 * random_vector(&random);
    const BodyDistance found = body_distance(*model, 0, x, {c});
    const double expected = sampled(*model, x, {c});
    EXPECT_LE(found.distance, expected + 1e-8);
    EXPECT_GE(found.distance, expected - 0.001);  // a step: 1/60 of an edge of at most 0.1 m, 0.6 of it off at most
    EXPECT_NEAR((found.on_body - found.on_collider).norm(), std::abs(found.distance), 1e-12);
    SurfaceQuery query(c.shapes[0]);
    query.place(c.world_from_collider);
    SurfacePoint surface;
    ASSERT_TRUE(query.find(found.on_collider, 1.0, &surface));
    EXPECT_NEAR(surface.distance, 0.0, 1e-9);
    apart += found.distance > 0.0 ? 1 : 0;
    deep += found.distance < -0.005 ? 1 : 0;
  }
  EXPECT_GT(apart, 5);
  EXPECT_GT(deep, 5);
}

INSTANTIATE_TEST_SUITE_P(Every, DistanceTo,
                         testing::Values(Case{"box", Shape::Type::kBox, Vec3(0.1, 0.07, 0.05)},
                                         Case{"sphere", Shape::Type::kSphere, Vec3(0.05, 0, 0)},
                                         Case{"cylinder", Shape::Type::kCylinder, Vec3(0.03, 0.1, 0)},
                                         Case{"capsule", Shape::Type::kCapsule, Vec3(0.03, 0.05, 0)},
                                         Case{"cone", Shape::Type::kCone, Vec3(0.05, 0.1, 0)},
                                         Case{"plane", Shape::Type::kPlane, Vec3::Zero()}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(BodyDistance, SeesABallBetweenTheNodesOfACoarseSheet) {
  // Two triangles of 1 m, a ball of R under the middle of one: d = h - R - r, above and, deep, below.
  const auto model = sheet(1.0, 1);
  for (const double h : {0.3, 0.1, 0.05, 0.02}) {
    Collider ball = test::collider("ball", Shape::Type::kSphere, Vec3(0.05, 0, 0), test::at(0.13, -0.21, -h));
    const BodyDistance found = body_distance(*model, 0, model->initial.x, {ball});
    EXPECT_NEAR(found.distance, h - 0.05 - kRadius, 1e-8);
    EXPECT_NEAR((found.on_collider - Vec3(0.13, -0.21, -h + 0.05)).norm(), 0.0, 1e-4);  // sqrt(2 h 1e-8) at most
    EXPECT_EQ(found.collider, 0);
  }
}

TEST(BodyDistance, IsThatOfEdgeToEdge) {
  // The sheet's edge along y at x = 0.05 over the edge of a box turned by 45 degrees about x: they cross at right
  // angles, d = height of the one over the other - r.
  const auto model = sheet(0.1, 3);
  const double ridge = 0.1 * std::sqrt(0.5);
  Collider box = test::collider("box", Shape::Type::kBox, Vec3(0.1, 0.1, 0.1),
                                test::at(0.05, 0.003, -ridge - 0.02, 0.25 * M_PI, Vec3::UnitX()));
  const BodyDistance found = body_distance(*model, 0, model->initial.x, {box});
  EXPECT_NEAR(found.distance, 0.02 - kRadius, 1e-8);
  EXPECT_NEAR(found.on_collider.z(), -0.02, 1e-8);
  EXPECT_NEAR(found.on_collider.y(), 0.003, 1e-6);
}

TEST(BodyDistance, TakesTheNearestOfManyShapesAndSkipsNone) {
  const auto model = sheet(0.1, 4);
  std::vector<Collider> colliders;
  for (int k = 0; k < 5; ++k)
    colliders.push_back(test::collider("c" + std::to_string(k), Shape::Type::kSphere, Vec3(0.05, 0, 0),
                                       test::at(0.02 * k, 0.0, k == 3 ? 0.2 : 0.3)));
  const BodyDistance found = body_distance(*model, 0, model->initial.x, colliders);
  EXPECT_EQ(found.collider, 3);
}

TEST(BodyDistance, ToSolidsThatAreNotConvexIsThatToTheirParts) {
  // Voxels: the least distance to their cubes as boxes. An L: that to its two arms.
  const auto model = sheet(0.15, 3);
  const test::VoxelGrid grid(
      [](int x, int y, int z) { return z <= 3 + x / 3 + y / 5 || (x == 9 && y == 4 && z < 14); });
  const VoxelSolid solid(grid.cubes(), test::kCell);
  Collider map = test::collider("map", Shape::Type::kVoxels, Vec3::Zero(), Pose::Identity());
  map.shapes[0].voxels = std::make_shared<const VoxelSolid>(grid.cubes(), test::kCell);
  Collider boxes = test::collider("boxes", Shape::Type::kBox, Vec3::Ones(), Pose::Identity());
  boxes.shapes.clear();
  for (const VoxelCube& cube : solid.cubes()) {
    Shape box;
    box.size = Vec3::Constant(test::kCell * (1 << cube.level));
    for (int k = 0; k < 3; ++k)
      box.collider_from_shape.translation()[k] =
          test::kCell * (cube.key[static_cast<size_t>(k)] - kVoxelOrigin) + 0.5 * box.size[k];
    boxes.shapes.push_back(box);
  }
  std::mt19937 random(42);
  int compared = 0, cut = 0;
  for (int k = 0; k < 80; ++k) {
    const Pose pose = test::at(0, 0, 0.05, random_vector(&random).x(), random_vector(&random));
    Nodes x = model->initial.x;
    for (int i = 0; i < x.cols(); ++i) x.col(i) = pose * Vec3(x.col(i) + 0.03 * random_vector(&random));
    x.colwise() += 0.15 * random_vector(&random);
    map.world_from_collider = boxes.world_from_collider = test::at(0.1, 0, -0.1, 1.0, Vec3(1, 2, 3));
    const double to_map = body_distance(*model, 0, x, {map}).distance;
    const double to_boxes = body_distance(*model, 0, x, {boxes}).distance;
    if (to_boxes > -kRadius + 1e-7) {
      EXPECT_NEAR(to_map, to_boxes, 2e-8);
      ++compared;
      continue;
    }
    // Overlapping: as deep as the deepest node.
    double deepest = -kRadius;
    for (int i = 0; i < x.cols(); ++i)
      deepest = std::min(deepest, grid.distance(map.world_from_collider.inverse() * Vec3(x.col(i))) - kRadius);
    EXPECT_NEAR(to_map, deepest, 1e-9);
    ++cut;
  }
  EXPECT_GT(compared, 10);
  EXPECT_GT(cut, 10);
}

TEST(BodyDistance, OfARopeIsThatOfItsSegments) {
  // A rope of one segment along x at height h over a ball of R below its middle: d = h - R - r.
  auto model = test::points_model((Nodes(3, 2) << -0.5, 0.5, 0, 0, 0.2, 0.2).finished(), 0.01, Vec3::Zero());
  model->bodies[0].line = std::make_shared<Polyline>(make_line(1.0, 1));
  model->bodies[0].contact_radius = kRadius;
  const Collider ball = test::collider("ball", Shape::Type::kSphere, Vec3(0.05, 0, 0), test::at(0.1, 0, 0));
  const BodyDistance found = body_distance(*model, 0, model->initial.x, {ball});
  EXPECT_NEAR(found.distance, 0.15 - kRadius, 1e-8);
  EXPECT_NEAR(found.on_body.z(), 0.2 - kRadius, 1e-8);
}

}  // namespace
}  // namespace deformable_sim
