// Where edges and faces come nearest to convex shapes, against places tried one by one.
#include "deformable_sim/core/contact/deepest_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace deformable_sim::test {
namespace {

SurfaceQuery query(Shape::Type type, const Vec3& size) {
  Shape shape;
  shape.type = type;
  shape.size = size;
  SurfaceQuery query(shape);
  query.place(Pose(Eigen::Translation3d(0.01, -0.02, 0.03) * Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized())));
  return query;
}

/// Least distance over a grid of weights.
double least(const ContactPoint& point, const Nodes& x, SurfaceQuery* shape) {
  constexpr int kParts = 100;
  double least = 1e9;
  for (int i = 0; i <= kParts; ++i) {
    for (int j = 0; j <= (point.count == 3 ? kParts - i : 0); ++j) {
      const double a = static_cast<double>(i) / kParts, b = static_cast<double>(j) / kParts;
      const Vec3 p = point.count == 2 ? Vec3((1.0 - a) * x.col(0) + a * x.col(1))
                                      : Vec3((1.0 - a - b) * x.col(0) + a * x.col(1) + b * x.col(2));
      SurfacePoint surface;
      if (shape->find(p, 10.0, &surface)) least = std::min(least, surface.distance);
    }
  }
  return least;
}

TEST(DeepestPlace, OfAnEdgeIsTheLeastDistanceToTheShape) {
  // min over t of d((1 - t) a + t b): within 1/1000 of the edge, and by steps of 1/100 no worse than tried.
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto type : {Shape::Type::kBox, Shape::Type::kSphere, Shape::Type::kCylinder, Shape::Type::kCapsule}) {
    SurfaceQuery shape = query(type, Vec3(0.1, 0.15, 0.2));
    for (int trial = 0; trial < 500; ++trial) {
      Nodes x(3, 3);
      for (Eigen::Index i = 0; i < 9; ++i) x.data()[i] = 0.3 * unit(generator);
      const ContactPoint edge{{{0, 1, -1}}, 2, 0};
      Place place;
      ASSERT_TRUE(find_deepest_place(edge, x, 10.0, &shape, &place));
      const double length = (x.col(1) - x.col(0)).norm();
      EXPECT_LT(place.surface.distance, least(edge, x, &shape) + 2e-3 * length);
      EXPECT_GT(place.surface.distance, least(edge, x, &shape) - 1e-2 * length);
      EXPECT_NEAR(place.weight[0] + place.weight[1], 1.0, 1e-12);
      EXPECT_LT((place.weight[0] * x.col(0) + place.weight[1] * x.col(1) - place.p).norm(), 1e-12);
    }
  }
}

TEST(DeepestPlace, OfAFaceIsTheLeastDistanceToTheShape) {
  // Two searches, each within 1/128 of a length of up to two extents.
  std::mt19937 generator(6);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const auto type : {Shape::Type::kBox, Shape::Type::kCylinder}) {
    SurfaceQuery shape = query(type, Vec3(0.1, 0.15, 0.2));
    for (int trial = 0; trial < 100; ++trial) {
      Nodes x(3, 3);
      for (Eigen::Index i = 0; i < 9; ++i) x.data()[i] = 0.3 * unit(generator);
      const ContactPoint face{{{0, 1, 2}}, 3, 0};
      Place place;
      ASSERT_TRUE(find_deepest_place(face, x, 10.0, &shape, &place));
      const double expected = least(face, x, &shape);
      // Within the shape distances have kinks, at which one normal does not tell which way is down.
      if (expected < 0.0) {
        EXPECT_LT(place.surface.distance, 0.0);
      } else {
        EXPECT_LT(place.surface.distance, expected + 4.0 / 128 * extent_of(face, position(face, x), x));
      }
      EXPECT_LT((x * Vec3(place.weight[0], place.weight[1], place.weight[2]) - place.p).norm(), 1e-12);
    }
  }
}

TEST(DeepestPlace, OfAFaceFindsTheCornerThatPokesAtIt) {
  // The corner of a box, and a thin post, below the inside of a level triangle: the place is above them, not at the
  // centroid.
  for (const double side : {0.1, 0.002}) {
    Shape box;
    box.type = Shape::Type::kBox;
    box.size = Vec3(side, side, 0.2);
    SurfaceQuery shape(box);
    shape.place(Pose(Eigen::Translation3d(0.004 - 0.5 * side, 0.003 - 0.5 * side, -0.1)));
    Nodes x(3, 3);
    x.col(0) = Vec3(-0.002, -0.002, 0.001);
    x.col(1) = Vec3(0.03, -0.002, 0.0011);
    x.col(2) = Vec3(-0.002, 0.03, 0.0012);
    const ContactPoint face{{{0, 1, 2}}, 3, 0};
    Place place;
    ASSERT_TRUE(find_deepest_place(face, x, 0.05, &shape, &place));
    EXPECT_LT(place.surface.distance, least(face, x, &shape) + 0.04 / 128) << side;
  }
}

TEST(DeepestPlace, LeavesOutWhatIsOutOfReach) {
  SurfaceQuery shape = query(Shape::Type::kSphere, Vec3(0.1, 0, 0));
  Nodes x(3, 2);
  x.col(0) = Vec3(1.0, 0, 0);
  x.col(1) = Vec3(1.2, 0, 0);
  const ContactPoint edge{{{0, 1, -1}}, 2, 0};
  Place place;
  EXPECT_FALSE(find_deepest_place(edge, x, 0.5, &shape, &place));
  EXPECT_TRUE(find_deepest_place(edge, x, 1.2, &shape, &place));
  EXPECT_NEAR(extent_of(edge, Vec3(1.1, 0, 0), x), 0.1, 1e-12);
}

}  // namespace
}  // namespace deformable_sim::test
