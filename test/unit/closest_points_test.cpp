// Nearest points of triangles and segments, and pairs of boxes, against searches that try everything.
#include "deformable_sim/core/contact/closest_points.h"

#include <gtest/gtest.h>

#include <random>

namespace deformable_sim {
namespace {

class Points {
 public:
  Vec3 operator()() { return {unit_(generator_), unit_(generator_), unit_(generator_)}; }
  double share() { return 0.5 * (1.0 + unit_(generator_)); }

 private:
  std::mt19937 generator_{3};
  std::uniform_real_distribution<double> unit_{-1.0, 1.0};
};

/// Nothing is nearer than the points found: for convex pieces it is enough that no step towards a corner of either
/// shortens the way, (q' - q) . apart <= 0 for the second piece and >= 0 for the first.
void expect_nearest(const ClosestPoints& c, const std::vector<Vec3>& first, const std::vector<Vec3>& second) {
  Vec3 p = Vec3::Zero(), q = Vec3::Zero();
  double of_p = 0.0, of_q = 0.0;
  for (size_t k = 0; k < first.size(); ++k) {
    p += c.weight[k] * first[k];
    of_p += c.weight[k];
    EXPECT_GE(c.weight[k], 0.0);
  }
  for (size_t k = 0; k < second.size(); ++k) {
    q += c.weight[first.size() + k] * second[k];
    of_q += c.weight[first.size() + k];
    EXPECT_GE(c.weight[first.size() + k], 0.0);
  }
  EXPECT_NEAR(of_p, 1.0, 1e-12);
  EXPECT_NEAR(of_q, 1.0, 1e-12);
  EXPECT_LT((p - q - c.apart).norm(), 1e-12);
  for (const Vec3& corner : first) EXPECT_GE((corner - p).dot(c.apart), -1e-9);
  for (const Vec3& corner : second) EXPECT_LE((corner - q).dot(c.apart), 1e-9);
}

TEST(ClosestPoints, OfAPointAndATriangleAreNearerThanAllOthers) {
  Points random;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 p = random(), a = random(), b = random(), c = random();
    expect_nearest(closest_point_triangle(p, a, b, c), {p}, {a, b, c});
  }
}

TEST(ClosestPoints, OfTwoSegmentsAreNearerThanAllOthers) {
  Points random;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 a = random(), b = random(), c = random(), d = random();
    expect_nearest(closest_segment_segment(a, b, c, d), {a, b}, {c, d});
  }
}

TEST(ClosestPoints, KnowPiecesWithoutAreaOrLengthAndParallelOnes) {
  Points random;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = random(), a = random(), u = random();
    const Vec3 on = a + random.share() * u;
    expect_nearest(closest_point_triangle(p, a, a + u, on), {p}, {a, a + u, on});
    const ClosestPoints at_point = closest_point_triangle(p, a, a, a);
    EXPECT_LT((at_point.apart - (p - a)).norm(), 1e-12);
    expect_nearest(closest_segment_segment(p, p, a, a + u), {p, p}, {a, a + u});
    expect_nearest(closest_segment_segment(a, a + u, p, p), {a, a + u}, {p, p});
    const Vec3 c = p + (3.0 * random.share() - 1.0) * u, d = c - random.share() * u;
    expect_nearest(closest_segment_segment(a, a + u, c, d), {a, a + u}, {c, d});
  }
  // Where they overlap, the middle of what is common.
  const ClosestPoints c = closest_segment_segment(Vec3(0, 0, 1), Vec3(4, 0, 1), Vec3(3, 0, 0), Vec3(1, 0, 0));
  EXPECT_NEAR(c.weight[1], 0.5, 1e-12);
  EXPECT_NEAR(c.weight[3], 0.5, 1e-12);
}

}  // namespace
}  // namespace deformable_sim
