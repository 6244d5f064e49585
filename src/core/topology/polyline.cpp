#include "deformable_sim/core/topology/polyline.h"

#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

void check_length(double length) {
  if (!(length > 0.0) || !std::isfinite(length)) {
    throw InputError("length is " + std::to_string(length) + " m; it must be finite and > 0");
  }
}

}  // namespace

Polyline make_line(double length, int segments) {
  check_length(length);
  if (segments < 1) throw InputError("segments is " + std::to_string(segments) + "; an open line needs at least 1");
  Polyline line;
  line.rest = Nodes::Zero(3, segments + 1);
  for (int i = 0; i <= segments; ++i) line.rest(0, i) = length * (static_cast<double>(i) / segments - 0.5);
  return line;
}

Polyline make_ring(double length, int segments) {
  check_length(length);
  if (segments < 3) throw InputError("segments is " + std::to_string(segments) + "; a closed line needs at least 3");
  Polyline line;
  line.closed = true;
  line.rest = Nodes::Zero(3, segments);
  const double radius = 0.5 * length / segments / std::sin(M_PI / segments);
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * M_PI * i / segments;
    line.rest.col(i) = radius * Vec3(std::cos(angle), std::sin(angle), 0.0);
  }
  return line;
}

}  // namespace deformable_sim
