// A rope that slips around a drum.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "support/small_worlds.h"
#include "support/system.h"
#include "support/verification.h"

namespace deformable_sim::test {
namespace {

constexpr double kRadius = 0.1;  // m, of drum and half the rope
constexpr double kLeg = 0.15;    // m, of each straight end
constexpr int kOnDrum = 64;      // segments

class Capstan : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Schemes, Capstan, testing::Values("implicit_euler", "bdf2", "tr_bdf2", "substepped_verlet"),
                         [](const auto& info) { return info.param; });

/// Half a turn over a drum along y, ends down, stretched by 1 %.
std::shared_ptr<Model> rope(double friction) {
  const double segment = M_PI * kRadius / kOnDrum;
  const int on_leg = static_cast<int>(std::lround(kLeg / segment)), count = kOnDrum + 2 * on_leg + 1;
  Nodes x(3, count);
  for (int i = 0; i < count; ++i) {
    const int k = i - on_leg;
    if (k < 0) {
      x.col(i) = Vec3(-kRadius, 0, k * segment);
    } else if (k > kOnDrum) {
      x.col(i) = Vec3(kRadius, 0, (kOnDrum - k) * segment);
    } else {
      const double angle = M_PI * (1.0 - static_cast<double>(k) / kOnDrum);
      x.col(i) = kRadius * Vec3(std::cos(angle), 0, std::sin(angle));
    }
  }
  auto model = points_model(x, 0.002, Vec3::Zero());
  model->bodies[0].friction = friction;
  model->bodies[0].contact_radius = 0.005;
  std::vector<SpringLink> links;
  for (int i = 0; i + 1 < count; ++i) {
    SpringLink link;
    link.a = i;
    link.b = i + 1;
    link.rest_length = (x.col(i + 1) - x.col(i)).norm() / 1.01;
    link.stiffness = 25.0 / link.rest_length;  // EA = 25 N
    link.damping = 0.02 * link.stiffness;
    links.push_back(link);
  }
  model->energies.push_back(make_springs("rope", links, 0));
  model->energies.push_back(make_mass_damping(model->mass, 20.0));
  return model;
}

TEST_P(Capstan, TensionsDifferByTheExponentialOfMuPhi) {
  // T2 / T1 = e^(mu phi), phi = pi, within 2 %: the polygon of 64 segments is below 0.1 % off, and planes turned with
  // the drum to the end of a step bring omega dt pi = 0.3 %.
  const bool quick = GetParam() != "substepped_verlet";
  for (const double mu : quick ? std::vector<double>{0.1, 0.3, 0.5} : std::vector<double>{0.3}) {
    const auto model = rope(mu);
    Collider drum =
        collider("drum", Shape::Type::kCylinder, Vec3(kRadius - 0.005, 0.3, 0), at(0, 0, 0, 0.5 * M_PI, Vec3(1, 0, 0)));
    drum.friction = mu;
    WorldSettings settings;
    settings.dt = 1.0 / 240.0;
    settings.integrator = GetParam();
    settings.solver = exact_settings(1e-6);
    World world(model, settings, {drum},
                {grasp_nodes("slack", "points", {0}), grasp_nodes("tight", "points", {model->node_count() - 1})});
    double sums[2] = {0.0, 0.0};
    for (int k = 1; k <= 8; ++k) {
      // 0.2 rad/s away from the tight end.
      Pose turned = Pose(Eigen::AngleAxisd(-0.05 * k, Vec3(0, 1, 0))) * drum.world_from_collider;
      ASSERT_TRUE(world.apply(command::MoveCollider{"drum", turned, 0.25}).status.ok());
      for (int i = 0; i < 60; ++i) {
        ASSERT_TRUE(world.step().ok);
        if (k <= 6) continue;
        const auto grasps = world.grasp_reports();
        for (size_t end = 0; end < 2; ++end) sums[end] += grasps[end].force.norm();
      }
    }
    check("B13", "half turn, T2 / T1, mu " + std::to_string(mu) + ", " + GetParam(), sums[1] / sums[0],
          std::exp(mu * M_PI), 0.02);
  }
}

}  // namespace
}  // namespace deformable_sim::test
