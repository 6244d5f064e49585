// FCL's sphere kernels, and the cone, against signed distance functions written by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "deformable_sim/core/contact/surface_query.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

// Signed distances in the shape's own frame.
double box_distance(const Vec3& p, const Vec3& size) {
  const Vec3 q = p.cwiseAbs() - 0.5 * size;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}
double sphere_distance(const Vec3& p, const Vec3& size) {
  return p.norm() - size[0];
}
double cylinder_distance(const Vec3& p, const Vec3& size) {
  const Eigen::Vector2d q(std::hypot(p.x(), p.y()) - size[0], std::abs(p.z()) - 0.5 * size[1]);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}
double capsule_distance(const Vec3& p, const Vec3& size) {
  const double z = std::clamp(p.z(), -0.5 * size[1], 0.5 * size[1]);
  return (p - Vec3(0, 0, z)).norm() - size[0];
}
/// In the half-plane of p: to the base and to the side, negative where p is on the inner side of both.
double cone_distance(const Vec3& p, const Vec3& size) {
  using Vec2 = Eigen::Vector2d;
  const Vec2 at(std::hypot(p.x(), p.y()), p.z());
  const auto to_segment = [&at](const Vec2& a, const Vec2& b) {
    return (a + std::clamp((b - a).dot(at - a) / (b - a).squaredNorm(), 0.0, 1.0) * (b - a) - at).norm();
  };
  const Vec2 rim(size[0], -0.5 * size[1]);
  const double nearest = std::min(to_segment(Vec2(0, rim.y()), rim), to_segment(rim, Vec2(0, -rim.y())));
  const bool inside = at.y() > rim.y() && at.x() < size[0] * (0.5 - at.y() / size[1]);
  return inside ? -nearest : nearest;
}
double plane_distance(const Vec3& p, const Vec3&) {
  return p.z();
}

struct Case {
  const char* name;
  Shape::Type type;
  Vec3 size;
  double (*distance)(const Vec3&, const Vec3&);
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name;
}

class SurfaceQueryOf : public testing::TestWithParam<Case> {};

TEST_P(SurfaceQueryOf, AgreesWithTheClosedFormInsideAndOutside) {
  // d = sdf(p); the nearest surface point is p - d n, and one step out along n the distance grows by that step.
  const Case& c = GetParam();
  Shape shape;
  shape.type = c.type;
  shape.size = c.size;
  SurfaceQuery query(shape);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(-1.0, 1.0);
  int inside = 0, outside = 0;
  for (int k = 0; k < 4000; ++k) {
    const Pose world_from_shape =
        test::at(in(random), in(random), in(random), 3.0 * in(random), Vec3(in(random), in(random), in(random) + 2.0));
    query.place(world_from_shape);
    const Vec3 local = 0.2 * Vec3(in(random), in(random), in(random));
    const double expected = c.distance(local, c.size);
    (expected < 0.0 ? inside : outside)++;
    SurfacePoint found;
    ASSERT_TRUE(query.find(world_from_shape * local, 0.5, &found));
    // Doubles of size 1 through one rotation: 1e-15 or so, tangents of curved surfaces a little more.
    EXPECT_NEAR(found.distance, expected, 1e-9);
    const Vec3 normal = world_from_shape.linear().transpose() * found.normal;
    EXPECT_NEAR(normal.norm(), 1.0, 1e-9);
    EXPECT_NEAR(c.distance(local - expected * normal, c.size), 0.0, 1e-9);
    const Vec3 surface = local - expected * normal;
    EXPECT_NEAR(c.distance(surface + 1e-3 * normal, c.size), 1e-3, 1e-9);
  }
  EXPECT_GT(inside, 40);
  EXPECT_GT(outside, 40);
}

TEST_P(SurfaceQueryOf, FindsNothingBeyondItsReach) {
  const Case& c = GetParam();
  Shape shape;
  shape.type = c.type;
  shape.size = c.size;
  SurfaceQuery query(shape);
  SurfacePoint found;
  const Vec3 p(0.0, 0.0, 0.3);
  const double distance = c.distance(p, c.size);
  EXPECT_FALSE(query.find(p, distance - 1e-6, &found));
  EXPECT_TRUE(query.find(p, distance + 1e-6, &found));
}

TEST_P(SurfaceQueryOf, GivesAUnitNormalWhereNoneIsNearest) {
  const Case& c = GetParam();
  Shape shape;
  shape.type = c.type;
  shape.size = c.size;
  SurfaceQuery query(shape);
  query.place(test::at(0.1, -0.2, 0.3));
  SurfacePoint found;
  ASSERT_TRUE(query.find(Vec3(0.1, -0.2, 0.3), 0.01, &found));
  EXPECT_NEAR(found.normal.norm(), 1.0, 1e-12);
  EXPECT_NEAR(found.distance, c.distance(Vec3::Zero(), c.size), 1e-12);
}

TEST_P(SurfaceQueryOf, BoxHoldsTheShapeTightly) {
  // Support of the box along every axis = support of the shape: points of the surface touch all six sides.
  const Case& c = GetParam();
  Shape shape;
  shape.type = c.type;
  shape.size = c.size;
  SurfaceQuery query(shape);
  if (!query.bounded()) {
    EXPECT_EQ(c.type, Shape::Type::kPlane);
    return;
  }
  const Pose pose = test::at(0.3, 0.1, -0.2, 0.7, Vec3(1, 2, -1));
  query.place(pose);
  for (int axis = 0; axis < 3; ++axis) {
    for (double side : {-1.0, 1.0}) {
      // A far plane point's nearest shape point lies towards it: its distance along the axis is the gap to the box
      // side.
      SurfacePoint found;
      const Vec3 p = query.box().center() + side * 1e4 * Vec3::Unit(axis);
      ASSERT_TRUE(query.find(p, 2e4, &found));
      const double gap = side * p[axis] - (side > 0 ? query.box().max() : -query.box().min())[axis];
      EXPECT_NEAR(found.distance, gap, 1e-5);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every, SurfaceQueryOf,
                         testing::Values(Case{"box", Shape::Type::kBox, Vec3(0.2, 0.3, 0.1), box_distance},
                                         Case{"plate", Shape::Type::kBox, Vec3(0.3, 0.3, 0.01), box_distance},
                                         Case{"sphere", Shape::Type::kSphere, Vec3(0.15, 0, 0), sphere_distance},
                                         Case{"cylinder", Shape::Type::kCylinder, Vec3(0.1, 0.2, 0), cylinder_distance},
                                         Case{"capsule", Shape::Type::kCapsule, Vec3(0.08, 0.15, 0), capsule_distance},
                                         Case{"cone", Shape::Type::kCone, Vec3(0.12, 0.2, 0), cone_distance},
                                         Case{"needle", Shape::Type::kCone, Vec3(0.06, 0.5, 0), cone_distance},
                                         Case{"plane", Shape::Type::kPlane, Vec3::Zero(), plane_distance}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace deformable_sim
