// The tube of a rope and the stripe of a rod, which turns with the material.
#include <gtest/gtest.h>

#include "deformable_sim/ros/body_drawing.h"
#include "ros/drawn_scene.h"

namespace deformable_sim {
namespace {

constexpr std::size_t kQuad = 6;  // vertices

/// Light takes at most 0.7 of a colour; a stripe is 0.4 of it. Of a body as bright as 0.8: below 0.3 * 0.8 is striped.
bool is_striped(const visualization_msgs::Marker& tube, std::size_t quad) {
  float brightest = 0.0f;
  for (std::size_t k = 0; k < kQuad; ++k) brightest = std::max(brightest, tube.colors[kQuad * quad + k].r);
  return brightest < 0.4f;
}

/// Angle about x of a vertex, from +y towards +z.
double angle_of(const geometry_msgs::Point& p) {
  return std::atan2(p.z, p.y);
}

/// Of all vertices of striped quads at this x: the least and largest angle from `middle`, rad.
std::pair<double, double> stripe_at(const visualization_msgs::Marker& tube, double x, double middle) {
  double least = 10.0, most = -10.0;
  for (std::size_t quad = 0; quad < tube.points.size() / kQuad; ++quad) {
    if (!is_striped(tube, quad)) continue;
    for (std::size_t k = kQuad * quad; k < kQuad * (quad + 1); ++k) {
      if (std::abs(tube.points[k].x - x) > 1e-9) continue;
      const double angle = std::remainder(angle_of(tube.points[k]) - middle, 2.0 * M_PI);
      least = std::min(least, angle);
      most = std::max(most, angle);
    }
  }
  return {least, most};
}

TEST(Tube, HasAStripeOfTheGivenWidthAboutTheFirstDirector) {
  // A part s of the circumference: from -pi s to pi s about the director, whatever the tube is cut into.
  for (const double stripe : {0.1, 0.25, 0.5, 0.7}) {
    for (const double turn : {0.0, 0.6, 2.0, -2.5}) {
      DrawnScene scene;
      scene.add_rod(6, turn).stripe = stripe;
      const auto [least, most] = stripe_at(body_marker(scene.snapshot, 0, OutputSpec()), 0.0, turn);
      EXPECT_NEAR(least, -M_PI * stripe, 1e-5) << turn;
      EXPECT_NEAR(most, M_PI * stripe, 1e-5) << turn;
    }
  }
}

TEST(Tube, WindsItsStripeByTheTwist) {
  // Segments turned by 0.3 k: the ring between segments k - 1 and k looks towards their mean, 0.3 (k - 1/2).
  DrawnScene scene;
  scene.add_rod(5, 0.0);
  for (int k = 0; k < 5; ++k) scene.snapshot.directors.col(k) = Vec3(0.0, std::cos(0.3 * k), std::sin(0.3 * k));
  const visualization_msgs::Marker tube = body_marker(scene.snapshot, 0, OutputSpec());
  for (int k = 1; k < 5; ++k) {
    const auto [least, most] = stripe_at(tube, -0.5 + 0.2 * k, 0.3 * (k - 0.5));
    EXPECT_NEAR(least + most, 0.0, 1e-5) << k;
  }
}

int count_striped(const visualization_msgs::Marker& tube) {
  int count = 0;
  for (std::size_t quad = 0; quad < tube.points.size() / kQuad; ++quad) count += is_striped(tube, quad) ? 1 : 0;
  return count;
}

TEST(Tube, HasNoStripeWithoutTwistOrWidth) {
  // Of a body as bright as 0.8, lit by 0.3 at least, nothing is darker than 0.24; but quads of eight sides have a
  // vertex that is brighter than 0.4.
  DrawnScene scene;
  Body& body = scene.add_rod(3, 0.0);
  EXPECT_EQ(count_striped(body_marker(scene.snapshot, 0, OutputSpec())), 3 * 2);  // a quarter of eight sides
  body.stripe = 0.0;
  EXPECT_EQ(count_striped(body_marker(scene.snapshot, 0, OutputSpec())), 0);
  body.stripe = 0.25;
  body.first_segment = -1;
  EXPECT_EQ(count_striped(body_marker(scene.snapshot, 0, OutputSpec())), 0);
}

}  // namespace
}  // namespace deformable_sim
