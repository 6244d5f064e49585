// Rays against convex shapes: what lies between entering and leaving is inside, and nothing else is.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "deformable_sim/core/camera/shape_rays.h"

namespace deformable_sim {
namespace {

/// A shape with its implicit function: negative inside.
struct Case {
  std::string name;
  Shape::Type type;
  Vec3 size;
  std::function<double(const Vec3&)> outside;
};

const Case kCases[] = {
    {"box",
     Shape::Type::kBox,
     {0.4, 0.6, 1.0},
     [](const Vec3& p) { return (p.cwiseAbs() - Vec3(0.2, 0.3, 0.5)).maxCoeff(); }},
    {"sphere", Shape::Type::kSphere, {0.4, 0, 0}, [](const Vec3& p) { return p.norm() - 0.4; }},
    {"cylinder",
     Shape::Type::kCylinder,
     {0.3, 0.8, 0},
     [](const Vec3& p) { return std::max(p.head<2>().norm() - 0.3, std::abs(p.z()) - 0.4); }},
    {"capsule",
     Shape::Type::kCapsule,
     {0.2, 0.6, 0},
     [](const Vec3& p) { return (p - Vec3(0, 0, std::clamp(p.z(), -0.3, 0.3))).norm() - 0.2; }},
    {"cone",
     Shape::Type::kCone,
     {0.4, 0.8, 0},
     [](const Vec3& p) { return std::max(p.head<2>().norm() - 0.5 * (0.4 - p.z()), -0.4 - p.z()); }},
};

Shape shape_of(const Case& c) {
  Shape shape;
  shape.type = c.type;
  shape.size = c.size;
  return shape;
}

TEST(ShapeRays, EnterAndLeaveWhereTheImplicitFunctionIsZero) {
  // F(o + t d) = 0 at both ends, < 0 between them, > 0 outside. F changes by at most |d| per t; roots of quadratics
  // here lose half the digits where the ray grazes, which 1e-6 m allows for.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    const Shape shape = shape_of(c);
    int hits = 0;
    for (int ray = 0; ray < 2000; ++ray) {
      const Vec3 o = 2.0 * point(), d = 0.5 * point() - o;
      const RayInterval within = inside(shape, o, d);
      for (int i = -40; i <= 80; ++i) {
        const double t = 0.05 * i + 0.013;
        const double away = c.outside(o + t * d);
        if (std::abs(away) < 1e-6) continue;
        ASSERT_EQ(away < 0.0, t >= within.enter && t <= within.leave) << "t = " << t << " F = " << away;
      }
      if (within.empty()) continue;
      ++hits;
      ASSERT_NEAR(c.outside(o + within.enter * d), 0.0, 1e-6);
      ASSERT_NEAR(c.outside(o + within.leave * d), 0.0, 1e-6);
    }
    EXPECT_GT(hits, 500);
    EXPECT_LT(hits, 1950);
  }
}

TEST(ShapeRays, AlongTheAxesAreNoSpecialCase) {
  // Along z through the centre: the ends of the shape. Beside it, further than its radius: nothing.
  const double ends[][2] = {{-0.5, 0.5}, {-0.4, 0.4}, {-0.4, 0.4}, {-0.5, 0.5}, {-0.4, 0.4}};
  for (std::size_t i = 0; i < std::size(kCases); ++i) {
    SCOPED_TRACE(kCases[i].name);
    const Shape shape = shape_of(kCases[i]);
    const RayInterval through = inside(shape, Vec3(0, 0, -2), Vec3(0, 0, 2));
    EXPECT_NEAR(through.enter, 0.5 * (ends[i][0] + 2.0), 1e-12);
    EXPECT_NEAR(through.leave, 0.5 * (ends[i][1] + 2.0), 1e-12);
    EXPECT_TRUE(inside(shape, Vec3(0.41, 0, -2), Vec3::UnitZ()).empty());
    EXPECT_TRUE(inside(shape, Vec3(0, 0.41, -2), Vec3::UnitZ()).empty());
  }
}

TEST(ShapeRays, FitIntoTheBoxAroundTheShape) {
  // The box is the smallest: the surface touches each of its six sides.
  const Vec3 halves[] = {{0.2, 0.3, 0.5}, {0.4, 0.4, 0.4}, {0.3, 0.3, 0.4}, {0.2, 0.2, 0.5}, {0.4, 0.4, 0.4}};
  for (std::size_t i = 0; i < std::size(kCases); ++i) {
    EXPECT_EQ(half_extents(shape_of(kCases[i])), halves[i]) << kCases[i].name;
  }
}

}  // namespace
}  // namespace deformable_sim
