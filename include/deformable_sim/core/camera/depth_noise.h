// What a real depth camera adds to, and leaves out of, a true depth image.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "deformable_sim/core/camera/pinhole.h"

namespace deformable_sim {

/// A structured-light, stereo or time-of-flight camera; all off by default. In this order:
///
/// 1. A surface whose normal is more than `grazing_angle` off the ray gives no return. The normal is that of the image,
///    so that both sides of an edge, where the depth jumps, are lost too.
/// 2. Axial noise, normally distributed, independent from pixel to pixel, with
///      sigma(z) = sigma + sigma_growth (z - sigma_distance)^2
///    ([Nguyen 2012] measure 1.2 mm, 1.9 mm/m^2 and 0.4 m on a Kinect).
/// 3. Disparity fx baseline / z in whole multiples of `disparity_step`.
/// 4. A part `dropout` of the pixels is lost by chance; so is what has left the camera's range.
///
/// Not good at: errors that neighbouring pixels share, shadows of the projector, several paths of light.
struct DepthNoise {
  double sigma = 0.0;                 // m, >= 0
  double sigma_growth = 0.0;          // 1/m, >= 0
  double sigma_distance = 0.0;        // m
  double baseline = 0.0;              // m, >= 0; 0: depths are not quantised
  double disparity_step = 0.125;      // pixels, > 0
  double grazing_angle = 0.5 * M_PI;  // rad, 0 ... pi/2
  double dropout = 0.0;               // 0 ... 1
  std::uint64_t seed = 0;

  bool any() const {
    return sigma > 0.0 || sigma_growth > 0.0 || baseline > 0.0 || grazing_angle < 0.5 * M_PI || dropout > 0.0;
  }
};

/// depth: m, NaN where nothing is seen, row by row. The same seed and frame number give the same noise.
void add_noise(const Pinhole& camera, const DepthNoise& noise, std::uint64_t frame, std::vector<float>* depth);

}  // namespace deformable_sim
