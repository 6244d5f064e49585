#include "deformable_sim/core/camera/pinhole.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace deformable_sim {

namespace {

constexpr double kSlack = 1e-6;  // pixels, for the roundoff of a projection

/// The smallest box around points of the image.
class Bounds {
 public:
  void add(const Pinhole& camera, const Vec3& p) {
    const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
    low_u_ = std::min(low_u_, u);
    high_u_ = std::max(high_u_, u);
    low_v_ = std::min(low_v_, v);
    high_v_ = std::max(high_v_, v);
  }

  PixelBox pixels(const Pinhole& camera) const {
    // Clamped while they are real: a whole number need not hold what is far outside.
    const auto first = [](double low) { return static_cast<int>(std::ceil(std::max(low - kSlack, 0.0))); };
    const auto last = [](double high, int size) {
      return static_cast<int>(std::floor(std::clamp(high + kSlack, -1.0, size - 1.0)));
    };
    if (!(low_u_ < camera.width) || !(low_v_ < camera.height)) return {};
    return {first(low_u_), last(high_u_, camera.width), first(low_v_), last(high_v_, camera.height)};
  }

 private:
  static constexpr double kFar = std::numeric_limits<double>::infinity();
  double low_u_ = kFar, high_u_ = -kFar, low_v_ = kFar, high_v_ = -kFar;
};

}  // namespace

PixelBox whole_image(const Pinhole& camera) {
  return {0, camera.width - 1, 0, camera.height - 1};
}

PixelBox pixels_of_hull(const Pinhole& camera, const Vec3* corners, int count) {
  Bounds bounds;
  int behind = 0, beyond = 0;
  for (int i = 0; i < count; ++i) {
    behind += corners[i].z() < camera.near ? 1 : 0;
    beyond += corners[i].z() > camera.far ? 1 : 0;
  }
  if (behind == count || beyond == count) return {};
  for (int i = 0; i < count; ++i) {
    if (corners[i].z() < camera.near) continue;
    bounds.add(camera, corners[i]);
    for (int j = 0; behind > 0 && j < count; ++j) {
      if (corners[j].z() >= camera.near) continue;
      const double part = (camera.near - corners[j].z()) / (corners[i].z() - corners[j].z());
      Vec3 cut = corners[j] + part * (corners[i] - corners[j]);
      cut.z() = camera.near;
      bounds.add(camera, cut);
    }
  }
  return bounds.pixels(camera);
}

}  // namespace deformable_sim
