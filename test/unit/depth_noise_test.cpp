// Noise of a depth camera: the statistics it promises, and the same bits for the same seed and frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/camera/depth_noise.h"

namespace deformable_sim {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

Pinhole camera_of(int width, int height) {
  Pinhole camera;
  camera.width = width;
  camera.height = height;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

std::vector<float> wall(const Pinhole& camera, double z) {
  return std::vector<float>(static_cast<std::size_t>(camera.width * camera.height), static_cast<float>(z));
}

std::vector<float> noisy(const Pinhole& camera, const DepthNoise& noise, std::vector<float> depth, int frame = 0) {
  add_noise(camera, noise, static_cast<std::uint64_t>(frame), &depth);
  return depth;
}

int count_lost(const std::vector<float>& depth) {
  return static_cast<int>(std::count_if(depth.begin(), depth.end(), [](float z) { return std::isnan(z); }));
}

TEST(DepthNoise, ThatIsOffChangesNothing) {
  const Pinhole camera = camera_of(8, 6);
  EXPECT_FALSE(DepthNoise().any());
  EXPECT_EQ(noisy(camera, DepthNoise(), wall(camera, 1.25)), wall(camera, 1.25));
}

TEST(DepthNoise, SpreadsAsItSays) {
  // sigma(z) = s + g (z - z0)^2. Of n = 90000 pixels the mean lies within 4 sigma / sqrt(n) of the truth, the standard
  // deviation within 4 / sqrt(2 n) = 1 % of sigma, and neighbours correlate by less than 4 / sqrt(n) = 0.013.
  const Pinhole camera = camera_of(300, 300);
  DepthNoise noise;
  noise.sigma = 0.0012;
  noise.sigma_growth = 0.0019;
  noise.sigma_distance = 0.4;
  for (const double z : {0.4, 1.5, 3.0}) {
    const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
    const std::vector<float> depth = noisy(camera, noise, wall(camera, z));
    const double n = static_cast<double>(depth.size());
    double sum = 0.0, squares = 0.0, products = 0.0, above = 0.0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const double error = static_cast<double>(depth[i]) - static_cast<double>(static_cast<float>(z));
      sum += error;
      squares += error * error;
      above += error > sigma ? 1.0 : 0.0;
      if (i > 0) products += error * (static_cast<double>(depth[i - 1]) - z);
    }
    EXPECT_NEAR(sum / n, 0.0, 4.0 * sigma / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(squares / n), sigma, 0.01 * sigma);
    EXPECT_NEAR(products / squares, 0.0, 0.014);
    EXPECT_NEAR(above / n, 0.15866, 0.005);  // a normal distribution has this part above one sigma
  }
}

TEST(DepthNoise, IsTheSameForTheSameSeedAndFrameOnly) {
  const Pinhole camera = camera_of(40, 30);
  DepthNoise noise;
  noise.sigma = 0.01;
  noise.dropout = 0.2;
  const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
    return std::equal(a.begin(), a.end(), b.begin(),
                      [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); });
  };
  const std::vector<float> first = noisy(camera, noise, wall(camera, 1.0), 5);
  EXPECT_TRUE(same(first, noisy(camera, noise, wall(camera, 1.0), 5)));
  EXPECT_FALSE(same(first, noisy(camera, noise, wall(camera, 1.0), 6)));
  noise.seed = 1;
  EXPECT_FALSE(same(first, noisy(camera, noise, wall(camera, 1.0), 5)));
}

TEST(DepthNoise, QuantisesDisparities) {
  // fx b / z is a multiple of the step: z moves by at most z^2 step / (2 fx b) to first order, 1.7 mm here at 1 m.
  Pinhole camera = camera_of(64, 48);
  camera.fx = 500.0;
  DepthNoise noise;
  noise.baseline = 0.075;
  noise.disparity_step = 0.125;
  std::vector<float> ramp = wall(camera, 0.0);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = 0.5f + 0.001f * static_cast<float>(i);
  const std::vector<float> depth = noisy(camera, noise, ramp);
  for (std::size_t i = 0; i < ramp.size(); ++i) {
    const double z = ramp[i], steps = 500.0 * 0.075 / 0.125 / depth[i];
    ASSERT_NEAR(steps, std::round(steps), 1e-4);
    ASSERT_LE(std::abs(500.0 * 0.075 / 0.125 / z - steps), 0.5 + 1e-4);
  }
}

TEST(DepthNoise, LosesSurfacesSeenTooObliquely) {
  // The plane y = h below the camera makes the angle acos(h / |range|) with its normal: cosine = down / |ray|.
  Pinhole camera = camera_of(60, 80);
  camera.fx = camera.fy = 100.0;
  DepthNoise noise;
  noise.grazing_angle = 1.48;  // 85 degrees
  std::vector<float> floor = wall(camera, 0.0);
  for (int v = 0; v < camera.height; ++v) {
    const double down = camera.ray(0, v).y();
    const double z = 0.2 / down;
    for (int u = 0; u < camera.width; ++u) {
      floor[static_cast<std::size_t>(v * camera.width + u)] = down > 0.0 && z < 9.0 ? static_cast<float>(z) : kNothing;
    }
  }
  const std::vector<float> depth = noisy(camera, noise, floor);
  int kept = 0, lost = 0;
  for (int v = 1; v + 1 < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v * camera.width + u);
      if (std::isnan(floor[pixel])) {
        ASSERT_TRUE(std::isnan(depth[pixel]));
        continue;
      }
      const Vec3 ray = camera.ray(u, v);
      const double cosine = ray.y() / ray.norm();
      if (std::abs(cosine - std::cos(1.48)) < 1e-3) continue;  // roundoff of float32 decides
      const bool gone = cosine < std::cos(1.48) || std::isnan(floor[pixel - static_cast<std::size_t>(camera.width)]);
      ASSERT_EQ(std::isnan(depth[pixel]), gone) << u << " " << v;
      ++(gone ? lost : kept);
    }
  }
  EXPECT_GT(kept, 500);
  EXPECT_GT(lost, 50);
}

TEST(DepthNoise, LosesBothSidesOfAnEdge) {
  // Depth jumps from 1 m to 2 m between columns 9 and 10: those two, whose neighbours lie on both sides.
  const Pinhole camera = camera_of(20, 10);
  DepthNoise noise;
  noise.grazing_angle = 1.4;
  std::vector<float> step = wall(camera, 1.0);
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = i % 20 < 10 ? 1.0f : 2.0f;
  const std::vector<float> depth = noisy(camera, noise, step);
  for (std::size_t i = 0; i < step.size(); ++i) EXPECT_EQ(std::isnan(depth[i]), i % 20 == 9 || i % 20 == 10) << i;
}

TEST(DepthNoise, LosesPixelsByChance) {
  // Binomial: of n = 40000 a part p = 0.3 +- 4 sqrt(p (1 - p) / n) = 0.0092. 1 loses all.
  const Pinhole camera = camera_of(200, 200);
  DepthNoise noise;
  noise.dropout = 0.3;
  EXPECT_NEAR(count_lost(noisy(camera, noise, wall(camera, 1.0))) / 40000.0, 0.3, 0.0092);
  noise.dropout = 1.0;
  EXPECT_EQ(count_lost(noisy(camera, noise, wall(camera, 1.0))), 40000);
}

TEST(DepthNoise, DoesNotLeaveTheRangeOfTheCamera) {
  // A wall at far: half of the pixels are scattered beyond it and lost, none is seen there; nor is there any depth
  // where nothing was.
  const Pinhole camera = camera_of(200, 200);
  DepthNoise noise;
  noise.sigma = 0.05;
  std::vector<float> truth = wall(camera, camera.far);
  truth[7] = kNothing;
  const std::vector<float> depth = noisy(camera, noise, truth);
  EXPECT_NEAR(count_lost(depth) / 40000.0, 0.5, 0.01);
  EXPECT_TRUE(std::isnan(depth[7]));
  for (const float z : depth) EXPECT_FALSE(z > camera.far);
}

}  // namespace
}  // namespace deformable_sim
