#include "deformable_sim/core/topology/polygon_cut.h"

#include <cmath>

namespace deformable_sim {

CutPolygon cut(const Polygon& polygon, const Vec3& normal, double offset, double tolerance) {
  std::vector<double> height(polygon.size());
  bool any_inside = false, any_outside = false;
  for (size_t k = 0; k < polygon.size(); ++k) {
    height[k] = normal.dot(polygon[k]) - offset;
    if (std::abs(height[k]) <= tolerance) height[k] = 0.0;
    any_inside = any_inside || height[k] > 0.0;
    any_outside = any_outside || height[k] < 0.0;
  }
  if (!any_outside) return {polygon, {}};
  if (!any_inside) return {{}, polygon};
  CutPolygon parts;
  for (size_t k = 0; k < polygon.size(); ++k) {
    const size_t next = (k + 1) % polygon.size();
    if (height[k] >= 0.0) parts.inside.push_back(polygon[k]);
    if (height[k] <= 0.0) parts.outside.push_back(polygon[k]);
    if (height[k] * height[next] >= 0.0) continue;
    const double t = height[k] / (height[k] - height[next]);
    const Vec3 between = (1.0 - t) * polygon[k] + t * polygon[next];
    parts.inside.push_back(between);
    parts.outside.push_back(between);
  }
  return parts;
}

}  // namespace deformable_sim
