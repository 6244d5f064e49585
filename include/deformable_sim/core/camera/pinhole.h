// A camera without distortion, and which pixels a convex thing can cover.
#pragma once

#include <vector>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Optical frame: x right, y down, z forward, m. The centre of pixel (u, v), counted from 0, sees along
///
///   d = ((u - cx) / fx, (v - cy) / fy, 1)
///
/// so that the point t d has depth z = t.
struct Pinhole {
  int width = 640, height = 480;  // pixels
  double fx = 525.0, fy = 525.0;  // pixels, focal lengths
  double cx = 319.5, cy = 239.5;  // pixels, principal point
  double near = 0.1, far = 10.0;  // m, range of z that is seen, both ends included; 0 < near < far

  Vec3 ray(int u, int v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
};

/// Pixels first_u ... last_u, first_v ... last_v; empty when a last is below its first.
struct PixelBox {
  int first_u = 0, last_u = -1, first_v = 0, last_v = -1;

  bool empty() const { return last_u < first_u || last_v < first_v; }
};

PixelBox whole_image(const Pinhole& camera);

/// The pixels whose centres can see the convex hull of `corners` (m, optical frame) where it is not nearer than
/// camera.near: what lies before that plane is cut off before it is projected.
PixelBox pixels_of_hull(const Pinhole& camera, const Vec3* corners, int count);

}  // namespace deformable_sim
