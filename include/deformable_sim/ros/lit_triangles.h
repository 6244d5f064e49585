// Triangles for rviz with the light already in their colours.
#pragma once

#include <cmath>

#include <visualization_msgs/Marker.h>

#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// Brightness of surfaces seen from either side: ambient, key light, fill light.
class Light {
 public:
  /// `normal` is of unit length.
  float on(const Eigen::Vector3f& normal) const {
    return 0.3f + 0.5f * std::abs(normal.dot(key_)) + 0.2f * std::abs(normal.dot(fill_));
  }

 private:
  Eigen::Vector3f key_ = Eigen::Vector3f(0.35f, -0.45f, 0.82f).normalized();
  Eigen::Vector3f fill_ = Eigen::Vector3f(-0.7f, 0.6f, 0.4f).normalized();
};

/// Appends a point (m) and its colour, rgb 0 ... 1.
inline void add_vertex(const Vec3& at, const Eigen::Vector3f& color, visualization_msgs::Marker* marker) {
  geometry_msgs::Point point;
  point.x = at.x();
  point.y = at.y();
  point.z = at.z();
  marker->points.push_back(point);
  std_msgs::ColorRGBA shade;
  shade.r = color.x();
  shade.g = color.y();
  shade.b = color.z();
  shade.a = 1.0f;
  marker->colors.push_back(shade);
}

}  // namespace deformable_sim
