#include "deformable_sim/core/camera/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {

namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

/// splitmix64 [Steele 2014]: whole numbers in a row to numbers that look random.
std::uint64_t scramble(std::uint64_t n) {
  n += 0x9E3779B97F4A7C15u;
  n = (n ^ (n >> 30)) * 0xBF58476D1CE4E5B9u;
  n = (n ^ (n >> 27)) * 0x94D049BB133111EBu;
  return n ^ (n >> 31);
}

/// 32 bits to (0, 1).
double uniform(std::uint64_t bits) {
  return (static_cast<double>(bits & 0xFFFFFFFFu) + 0.5) / 4294967296.0;
}

/// Standard normal, from 64 random bits [Box 1958].
double normal(std::uint64_t bits) {
  return std::sqrt(-2.0 * std::log(uniform(bits))) * std::cos(2.0 * M_PI * uniform(bits >> 32));
}

/// The image of true depths that normals are taken from.
class Surface {
 public:
  Surface(const Pinhole& camera, const std::vector<float>& depth) : camera_(camera), depth_(depth) {}

  /// Cosine of the angle between ray and normal at a pixel that sees something: 0 at the rim of what is seen.
  double cosine(int u, int v) const {
    const Vec3 ray = camera_.ray(u, v);
    const Vec3 normal = difference(u, v, 1, 0).cross(difference(u, v, 0, 1));
    const double length = normal.norm() * ray.norm();
    return length > 0.0 ? std::abs(normal.dot(ray)) / length : 0.0;  // NaN beside nothing: not > 0
  }

 private:
  Vec3 point(int u, int v) const {
    const std::size_t pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width);
    return depth_[pixel + static_cast<std::size_t>(u)] * camera_.ray(u, v);
  }
  /// Between the neighbours on either side; at the border of the image between the pixel and the only one.
  Vec3 difference(int u, int v, int du, int dv) const {
    const int next_u = std::min(u + du, camera_.width - 1), next_v = std::min(v + dv, camera_.height - 1);
    const int last_u = std::max(u - du, 0), last_v = std::max(v - dv, 0);
    return point(next_u, next_v) - point(last_u, last_v);
  }

  const Pinhole& camera_;
  const std::vector<float>& depth_;
};

double quantised(const Pinhole& camera, const DepthNoise& noise, double z) {
  const double steps = std::round(camera.fx * noise.baseline / (noise.disparity_step * z));
  return camera.fx * noise.baseline / (noise.disparity_step * steps);  // infinite when no step is left
}

}  // namespace

void add_noise(const Pinhole& camera, const DepthNoise& noise, std::uint64_t frame, std::vector<float>* depth) {
  const bool grazes = noise.grazing_angle<0.5 * M_PI, scatters = noise.sigma> 0.0 || noise.sigma_growth > 0.0;
  const std::vector<float> truth = grazes ? *depth : std::vector<float>();
  const Surface surface(camera, truth);
  const double least_cosine = std::cos(noise.grazing_angle);
  const std::uint64_t start = scramble(scramble(noise.seed) ^ frame);
  std::size_t pixel = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++pixel) {
      float& out = (*depth)[pixel];
      double z = out;
      if (std::isnan(z)) continue;
      const std::uint64_t bits = scramble(start + 2 * pixel);
      if (scatters) {
        const double off = z - noise.sigma_distance;
        z += (noise.sigma + noise.sigma_growth * off * off) * normal(bits);
      }
      if (noise.baseline > 0.0) z = quantised(camera, noise, z);
      const bool lost = (grazes && surface.cosine(u, v) < least_cosine) ||
                        (noise.dropout > 0.0 && uniform(scramble(start + 2 * pixel + 1)) < noise.dropout);
      out = lost || !(z >= camera.near && z <= camera.far) ? kNothing : static_cast<float>(z);
    }
  }
}

}  // namespace deformable_sim
