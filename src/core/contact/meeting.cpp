#include "deformable_sim/core/contact/meeting.h"

#include <algorithm>
#include <limits>

namespace deformable_sim {

ClosestPoints closest_points(const Meeting& m, const Nodes& x) {
  const Vec3 a = x.col(m.node[0]), b = x.col(m.node[1]), c = x.col(m.node[2]), d = x.col(m.node[3]);
  return m.first == 1 ? closest_point_triangle(a, b, c, d) : closest_segment_segment(a, b, c, d);
}

bool stands_for_place(const Meeting& m, const ClosestPoints& found) {
  const auto on = [&](size_t k) { return found.weight[k] > 0.0; };
  if (m.first == 2) {
    // The end of an edge is a vertex, which has been tested against triangles, if those of the other are any.
    const bool a_inside = on(0) && on(1), b_inside = on(2) && on(3);
    return (a_inside || m.b->count == 2) && (b_inside || m.a->count == 2);
  }
  const int corners = (on(1) ? 1 : 0) + (on(2) ? 1 : 0) + (on(3) ? 1 : 0);
  if (corners == 3) return true;
  if (corners == 2) {
    const size_t edge = !on(3) ? 0 : !on(1) ? 1 : 2;
    return (m.b->own_edges >> edge & 1u) != 0u;
  }
  const size_t corner = on(1) ? 0 : on(2) ? 1 : 2;
  // The other way round it is found as well, but from segments.
  return (m.b->own_nodes >> corner & 1u) != 0u && (m.a->count == 2 || m.node[0] < m.node[corner + 1]);
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
