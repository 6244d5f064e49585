// What a camera sees of triangles and shapes: the nearest surface along the ray of each pixel, and whose it is.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deformable_sim/core/camera/pinhole.h"
#include "deformable_sim/core/contact/collider.h"

namespace deformable_sim {

/// A z-buffer. All that is drawn is given in the optical frame (m); surfaces are seen from both sides; what is nearer
/// than the camera's near plane is not seen and hides nothing. Labels are 1 ... 65535, 0 = nothing there.
///
/// Triangles are tested by the ray through the pixel's centre itself, in homogeneous coordinates [Olano 1997]:
/// with corners a, b, c the ray d meets their plane at 1/z = d . (a x b + b x c + c x a) / (a . (b x c)), and lies
/// within them where d . (a x b), d . (b x c) and d . (c x a) have one sign. So 1/z is exact in the plane, nothing is
/// clipped but the box of pixels, and no pixel falls between two triangles that share an edge.
///
/// Not good at: things thinner than a pixel, which are seen here and there (one ray a pixel).
class DepthBuffer {
 public:
  explicit DepthBuffer(const Pinhole& camera);

  const Pinhole& camera() const { return camera_; }
  void clear();

  void draw_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint16_t label);
  void draw_triangles(const Nodes& x, const std::vector<std::array<int, 3>>& triangles, std::uint16_t label);
  /// Any shape, `camera_from_shape` in place of its own pose; a plane is endless. A padded mesh is drawn bare.
  void draw_shape(const Shape& shape, const Pose& camera_from_shape, std::uint16_t label);
  /// All points nearer than `radius` (m) to the segment from a to b.
  void draw_tube(const Vec3& a, const Vec3& b, double radius, std::uint16_t label);

  /// z of each pixel (m), row by row from the top; NaN where nothing is seen.
  std::vector<float> depth() const;
  /// Row by row from the top.
  const std::vector<std::uint16_t>& labels() const { return labels_; }

 private:
  void draw_plane(const Pose& camera_from_plane, std::uint16_t label);
  void draw_convex(const Shape& shape, const Pose& camera_from_shape, std::uint16_t label);
  void draw_voxels(const VoxelSolid& voxels, const Pose& camera_from_voxels, std::uint16_t label);
  /// `inverse_depth`: 1/m, of a surface at this pixel.
  void put(std::size_t pixel, double inverse_depth, std::uint16_t label) {
    if (inverse_depth <= nearest_ && inverse_depth > inverse_[pixel]) {
      inverse_[pixel] = inverse_depth;
      labels_[pixel] = label;
    }
  }

  Pinhole camera_;
  double nearest_, farthest_;    // 1/m
  std::vector<double> inverse_;  // 1/z, 1/m; just below farthest_ where there is nothing
  std::vector<std::uint16_t> labels_;
};

}  // namespace deformable_sim
