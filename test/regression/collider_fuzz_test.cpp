// Colliders of all shapes and speeds against cloths and ropes: where nodes are, by brute force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "support/small_worlds.h"

namespace deformable_sim::test {
namespace {

constexpr double kStep = 1.0 / 60.0;  // s

double distance(const Shape& s, const Vec3& p) {
  const auto of_extents = [](double a, double b) {
    return std::min(0.0, std::max(a, b)) + std::hypot(std::max(a, 0.0), std::max(b, 0.0));
  };
  if (s.type == Shape::Type::kSphere) return p.norm() - s.size[0];
  if (s.type == Shape::Type::kCylinder)
    return of_extents(p.head<2>().norm() - s.size[0], std::abs(p.z()) - 0.5 * s.size[1]);
  if (s.type == Shape::Type::kCapsule) {
    const double half = 0.5 * s.size[1];
    return (p - Vec3(0, 0, std::clamp(p.z(), -half, half))).norm() - s.size[0];
  }
  const Vec3 beyond = p.cwiseAbs() - 0.5 * s.size;
  return beyond.cwiseMax(0.0).norm() + std::min(0.0, beyond.maxCoeff());
}

/// Least distance along the segment a b: a convex function of the place on it.
double distance(const Shape& s, const Vec3& a, const Vec3& b) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 40; ++k) {
    const double first = low + (high - low) / 3.0, second = high - (high - low) / 3.0;
    if (distance(s, a + first * (b - a)) < distance(s, a + second * (b - a))) {
      high = second;
    } else {
      low = first;
    }
  }
  return distance(s, a + 0.5 * (low + high) * (b - a));
}

struct Trial {
  Shape shape;
  Vec3 aim, direction;
  double speed;  // m/s
  Eigen::Quaterniond turned;
};

/// Spheres, boxes, plates of half a millimetre, capsules, cylinders and needles, of 2 mm to 0.3 m, at 0.3 to 100 m/s.
Trial trial_of(int seed) {
  std::mt19937 generator(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto u = [&] { return uniform(generator); };
  const double size = std::exp(u());
  const std::pair<Shape::Type, Vec3> shapes[] = {
      {Shape::Type::kSphere, Vec3(0.02 * size, 0, 0)},
      {Shape::Type::kBox, size * Vec3(0.04 + 0.02 * u(), 0.04 + 0.02 * u(), 0.04 + 0.02 * u())},
      {Shape::Type::kBox, Vec3(0.08 * size, 0.08 * size, 0.0005)},
      {Shape::Type::kCapsule, Vec3(0.01 * size, 0.06 * size, 0)},
      {Shape::Type::kCylinder, Vec3(0.02 * size, 0.05 * size, 0)},
      {Shape::Type::kBox, Vec3(0.004, 0.004, 0.2)},
  };
  Trial t;
  t.shape.type = shapes[seed % 6].first;
  t.shape.size = shapes[seed % 6].second;
  t.aim = Vec3(0.1 * u(), 0.1 * u(), 0.0);
  t.direction = Vec3(0.5 * u(), 0.5 * u(), 1.0).normalized();
  t.speed = 0.3 * std::pow(100.0 / 0.3, 0.5 + 0.5 * u());
  t.turned = Eigen::Quaterniond(u(), u(), u(), u()).normalized();
  return t;
}

class ColliderFuzz : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Schemes, ColliderFuzz, testing::Values("implicit_euler", "bdf2", "substepped_verlet"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(ColliderFuzz, NoNodeEndsInsideOrPassesThrough) {
  // Nodes keep 1 mm (rope: 3 mm) from a surface and may be 0.5 mm behind that: none is inside at the end of a step. A
  // collider that does not turn sees a node go straight in a step made in one part: the way is outside, too.
  const std::string cloth =
      "  - cloth: {name: body, size: [0.3, 0.3], cells: [12, 12], contact_radius: 0.001, material: {areal_density: "
      "0.2, "
      "membrane_stiffness: 300, bending_rigidity: 1.0e-5, damping: 0.001}}\n";
  const std::string rope =
      "  - rope: {name: body, length: 0.4, segments: 30, material: {diameter: 0.006, linear_density: 0.05, "
      "axial_stiffness: 500, damping: 0.001}}\n";
  const bool straight = std::string(GetParam()) != "substepped_verlet";
  for (int seed = 0; seed < 60; ++seed) {
    const bool of_rope = (seed / 6) % 3 == 2;
    Trial t = trial_of(seed);
    if (of_rope) t.aim.y() *= 0.02;
    const auto built =
        build_world(load_scene_text(std::string("gravity: [0, 0, 0]\nstep: {solver: manual, integrator: ") +
                                        GetParam() + "}\nbodies:\n" + (of_rope ? rope : cloth),
                                    "test"));
    WorldSettings settings = built->settings();
    settings.dt = kStep;
    settings.collider_max_speed = 200.0;
    constexpr double kBack = 0.25;  // m
    const auto pose = [&](double time) {
      return Pose(Eigen::Translation3d(t.aim + (t.speed * time - kBack) * t.direction) * t.turned);
    };
    Collider thrown = collider("thrown", t.shape.type, t.shape.size, pose(0.0));
    World world(built->shared_model(), settings, {thrown}, {});
    const int steps = std::clamp(static_cast<int>(std::ceil(0.6 / (t.speed * kStep))), 4, 40);
    for (int k = 1; k <= steps; ++k) {
      SCOPED_TRACE("trial " + std::to_string(seed) + ", step " + std::to_string(k) + ", m/s " +
                   std::to_string(t.speed));
      const Nodes before = world.state().x;
      const Pose begin = pose((k - 1) * kStep).inverse(), end = pose(k * kStep).inverse();
      ASSERT_TRUE(world.apply(command::MoveCollider{"thrown", pose(k * kStep), kStep}).status.ok());
      ASSERT_TRUE(world.step().ok);
      const Nodes& x = world.state().x;
      const bool whole = straight && world.snapshot(SnapshotDetail::kMotion).substeps == 1;
      for (Eigen::Index i = 0; i < x.cols(); ++i) {
        const Vec3 from = begin * before.col(i), to = end * x.col(i);
        ASSERT_GT(distance(t.shape, to), 0.0) << i;
        if (whole) ASSERT_GT(distance(t.shape, from, to), 0.0) << i;
      }
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
