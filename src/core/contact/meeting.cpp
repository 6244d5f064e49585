#include "deformable_sim/core/contact/meeting.h"

#include <algorithm>
#include <limits>

namespace deformable_sim {

ClosestPoints closest_points(const Meeting& m, const Nodes& x) {
  const Vec3 a = x.col(m.node[0]), b = x.col(m.node[1]), c = x.col(m.node[2]), d = x.col(m.node[3]);
  return m.first == 1 ? closest_point_triangle(a, b, c, d) : closest_segment_segment(a, b, c, d);
}

double gap_along(const Vec3& direction, const Meeting& m, const Nodes& x) {
  double low = std::numeric_limits<double>::max(), high = -low;
  for (int k = 0; k < 4; ++k) {
    const double at = direction.dot(x.col(m.node[static_cast<size_t>(k)]));
    if (k < m.first) {
      low = std::min(low, at);
    } else {
      high = std::max(high, at);
    }
  }
  return low - high;
}

}  // namespace deformable_sim
