#include "deformable_sim/ros/rope_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deformable_sim/ros/lit_triangles.h"

namespace deformable_sim {

namespace {

constexpr int kTubeSides = 8;

using Ring = Eigen::Matrix<float, 3, kTubeSides>;  // outward directions around a node

bool has_twist(const Snapshot& snapshot, const Body& body) {
  return body.first_segment >= 0 && snapshot.directors.cols() > 0;
}

/// The direction, about normal to the tube, in which its sides are counted at node i: of a rod with twist the mean
/// first director of the segments that meet there, of others the one before.
Eigen::Vector3f start_of_ring(const Snapshot& snapshot, const Body& body, int i, const Eigen::Vector3f& before) {
  if (!has_twist(snapshot, body)) return before;
  const int count = body.line->segment_count();
  const auto director = [&](int segment) {
    const int k = body.line->closed ? (segment + count) % count : std::clamp(segment, 0, count - 1);
    return Eigen::Vector3f(snapshot.directors.col(body.first_segment + k).cast<float>());
  };
  const Eigen::Vector3f sum = director(i - 1) + director(i);
  return sum.norm() > 1e-3f ? sum : director(i);  // half a turn from one segment to the next has no mean
}

/// Corners of a ring, as angles from the first director, and how many of its sides are the stripe, which it begins
/// with.
struct TubeSides {
  std::array<float, kTubeSides> angle;
  int striped = 0;

  explicit TubeSides(double stripe)
      : striped(stripe <= 0.0  ? 0
                : stripe < 1.0 ? std::clamp(static_cast<int>(std::lround(stripe * kTubeSides)), 1, kTubeSides - 1)
                               : kTubeSides) {
    const double width = striped == 0 || striped == kTubeSides ? static_cast<double>(striped) / kTubeSides : stripe;
    for (int k = 0; k < kTubeSides; ++k) {
      const double turned =
          k < striped ? width * k / striped : width + (1.0 - width) * (k - striped) / (kTubeSides - striped);
      angle[static_cast<std::size_t>(k)] = static_cast<float>(2.0 * M_PI * (turned - 0.5 * width));
    }
  }
};

/// The shade of a rod's stripe: darker, or lighter where there is nothing darker.
Eigen::Vector3f other_shade(const Eigen::Vector3f& color) {
  if (color.maxCoeff() > 0.4f) return 0.4f * color;
  return color + 0.6f * (Eigen::Vector3f::Ones() - color);
}

}  // namespace

void draw_tube(const Snapshot& snapshot, const Body& body, const std::vector<Eigen::Vector3f>& colors,
               visualization_msgs::Marker* marker) {
  const int n = body.node_count;
  const bool closed = body.line->closed;
  const Eigen::Matrix3Xf x = snapshot.x.middleCols(body.first_node, n).cast<float>();
  const auto at = [&](int i) { return x.col(closed ? (i + n) % n : std::clamp(i, 0, n - 1)); };
  std::vector<Ring> rings(static_cast<std::size_t>(n));
  const TubeSides sides(has_twist(snapshot, body) ? body.stripe : 0.0);
  Eigen::Vector3f side = Eigen::Vector3f::UnitZ();
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3f along = (at(i + 1) - at(i - 1)).normalized();
    side = start_of_ring(snapshot, body, i, side);
    side -= side.dot(along) * along;
    if (side.norm() < 1e-3f) side = along.unitOrthogonal();
    side.normalize();
    const Eigen::Vector3f other = along.cross(side);
    for (int k = 0; k < kTubeSides; ++k) {
      const float angle = sides.angle[static_cast<std::size_t>(k)];
      rings[static_cast<std::size_t>(i)].col(k) = std::cos(angle) * side + std::sin(angle) * other;
    }
  }
  const float radius = static_cast<float>(body.draw_radius);
  const Light light;
  for (int s = 0; s < body.line->segment_count(); ++s) {
    const auto [a, b] = body.line->segment(s);
    for (int k = 0; k < kTubeSides; ++k) {
      const auto vertex = [&, side_of_tube = k](int i, int corner) {
        const Eigen::Vector3f out = rings[static_cast<std::size_t>(i)].col(corner % kTubeSides);
        const Eigen::Vector3f& color = colors[static_cast<std::size_t>(i)];
        const bool second = side_of_tube < sides.striped;
        add_vertex((x.col(i) + radius * out).cast<double>(), light.on(out) * (second ? other_shade(color) : color),
                   marker);
      };
      for (const auto& [i, j] : {std::pair(a, k), std::pair(b, k), std::pair(b, k + 1)}) vertex(i, j);
      for (const auto& [i, j] : {std::pair(a, k), std::pair(b, k + 1), std::pair(a, k + 1)}) vertex(i, j);
    }
  }
}

void draw_frames(const Snapshot& snapshot, const Body& body, visualization_msgs::Marker* marker) {
  if (!has_twist(snapshot, body)) return;
  const Eigen::Vector3f red(0.9f, 0.1f, 0.1f), green(0.1f, 0.75f, 0.1f);
  for (int s = 0; s < body.line->segment_count(); ++s) {
    const auto [a, b] = body.line->segment(s);
    const Vec3 from = snapshot.x.col(body.first_node + a), to = snapshot.x.col(body.first_node + b);
    const Vec3 first = snapshot.directors.col(body.first_segment + s);
    const Vec3 second = snapshot.tangents.col(body.first_segment + s).cross(first);
    const Vec3 middle = 0.5 * (from + to);
    const double length = std::max((to - from).norm(), 3.0 * body.draw_radius);
    for (const auto& [direction, color] : {std::pair(first, red), std::pair(second, green)}) {
      add_vertex(middle, color, marker);
      add_vertex(middle + length * direction, color, marker);
    }
  }
}

}  // namespace deformable_sim
