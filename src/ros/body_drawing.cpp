#include "deformable_sim/ros/body_drawing.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {

namespace {

using Color = Eigen::Vector3f;

constexpr int kTubeSides = 8;
constexpr float kFastest = 1.0f;     // m/s shown as full colour
constexpr double kLineWidth = 5e-4;  // m

/// Brightness of a surface seen from either side: ambient, key light, fill light.
float light(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f key = Eigen::Vector3f(0.35f, -0.45f, 0.82f).normalized();
  const Eigen::Vector3f fill = Eigen::Vector3f(-0.7f, 0.6f, 0.4f).normalized();
  return 0.3f + 0.5f * std::abs(normal.dot(key)) + 0.2f * std::abs(normal.dot(fill));
}

/// Blue at -1, grey at 0, red at 1.
Color signed_color(float value) {
  const float s = std::clamp(value, -1.0f, 1.0f);
  const Color grey(0.85f, 0.85f, 0.85f);
  const Color end = s < 0.0f ? Color(0.1f, 0.25f, 0.95f) : Color(0.95f, 0.1f, 0.05f);
  return grey + std::abs(s) * (end - grey);
}

/// Unlit colour of each node.
std::vector<Color> node_colors(const Snapshot& snapshot, const Body& body, const OutputSpec& outputs) {
  const Color own(body.color[0], body.color[1], body.color[2]);
  std::vector<Color> colors(body.node_count, own);
  if (outputs.color_by == "strain") {
    const Eigen::VectorXf strain = node_strain(body, snapshot.x) / static_cast<float>(outputs.strain_range);
    for (int i = 0; i < body.node_count; ++i) colors[i] = signed_color(strain[i]);
  } else if (outputs.color_by == "velocity") {
    for (int i = 0; i < body.node_count; ++i) {
      colors[i] = signed_color(static_cast<float>(snapshot.v.col(body.first_node + i).norm()) / kFastest);
    }
  } else if (outputs.color_by == "contact" && snapshot.contact_force.size() > 0) {
    const auto force = snapshot.contact_force.segment(body.first_node, body.node_count);
    const Eigen::Index touching = (force.array() > 0.0f).count();
    const float full = touching > 0 ? 2.0f * force.sum() / static_cast<float>(touching) : 1.0f;
    for (int i = 0; i < body.node_count; ++i) colors[i] = signed_color(force[i] / full);
  }
  return colors;
}

void add_vertex(const Eigen::Vector3f& at, const Color& color, visualization_msgs::Marker* marker) {
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

void draw_sheet(const Snapshot& snapshot, const Body& body, std::vector<Color> colors,
                visualization_msgs::Marker* marker) {
  const Eigen::Matrix3Xf normals = node_normals(body, snapshot.x);
  const Eigen::Matrix3Xf x = snapshot.x.middleCols(body.first_node, body.node_count).cast<float>();
  for (int i = 0; i < body.node_count; ++i) colors[i] *= light(normals.col(i));
  for (const std::array<int, 3>& triangle : body.surface->triangles) {
    for (const int node : triangle) add_vertex(x.col(node), colors[node], marker);
  }
}

/// A ring of vertices around each node, carried along the line without twist, joined by quads.
void draw_tube(const Snapshot& snapshot, const Body& body, const std::vector<Color>& colors,
               visualization_msgs::Marker* marker) {
  const int n = body.node_count;
  const bool closed = body.line->closed;
  const Eigen::Matrix3Xf x = snapshot.x.middleCols(body.first_node, n).cast<float>();
  const auto at = [&](int i) { return x.col(closed ? (i + n) % n : std::clamp(i, 0, n - 1)); };
  std::vector<Eigen::Matrix<float, 3, kTubeSides>> rings(n);  // outward directions
  Eigen::Vector3f side = Eigen::Vector3f::UnitZ();
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3f along = (at(i + 1) - at(i - 1)).normalized();
    side -= side.dot(along) * along;
    if (side.norm() < 1e-3f) side = along.unitOrthogonal();
    side.normalize();
    const Eigen::Vector3f other = along.cross(side);
    for (int k = 0; k < kTubeSides; ++k) {
      const float angle = 2.0f * static_cast<float>(M_PI) * k / kTubeSides;
      rings[i].col(k) = std::cos(angle) * side + std::sin(angle) * other;
    }
  }
  const float radius = static_cast<float>(body.draw_radius);
  const auto vertex = [&](int i, int k) {
    const Eigen::Vector3f out = rings[i].col(k % kTubeSides);
    add_vertex(x.col(i) + radius * out, light(out) * colors[i], marker);
  };
  for (int s = 0; s < body.line->segment_count(); ++s) {
    const auto [a, b] = body.line->segment(s);
    for (int k = 0; k < kTubeSides; ++k) {
      for (const auto& [i, j] : {std::pair(a, k), std::pair(b, k), std::pair(b, k + 1)}) vertex(i, j);
      for (const auto& [i, j] : {std::pair(a, k), std::pair(b, k + 1), std::pair(a, k + 1)}) vertex(i, j);
    }
  }
}

}  // namespace

visualization_msgs::Marker blank_marker() {
  visualization_msgs::Marker marker;
  marker.pose.orientation.w = 1.0;
  return marker;
}

visualization_msgs::Marker body_marker(const Snapshot& snapshot, int body, const OutputSpec& outputs) {
  const Body& shape = snapshot.model->bodies[body];
  visualization_msgs::Marker marker = blank_marker();
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = 1.0f;
  const std::vector<Color> colors = node_colors(snapshot, shape, outputs);
  if (shape.surface) {
    draw_sheet(snapshot, shape, colors, &marker);
  } else {
    draw_tube(snapshot, shape, colors, &marker);
  }
  return marker;
}

visualization_msgs::Marker wireframe_marker(const Snapshot& snapshot, int body) {
  visualization_msgs::Marker marker = blank_marker();
  marker.type = visualization_msgs::Marker::LINE_LIST;
  marker.scale.x = kLineWidth;
  marker.color.r = marker.color.g = marker.color.b = 0.1f;
  marker.color.a = 1.0f;
  for (const StrainEdge& edge : snapshot.model->bodies[body].strain_edges) {
    for (const int node : edge.node) {
      geometry_msgs::Point point;
      point.x = snapshot.x(0, node);
      point.y = snapshot.x(1, node);
      point.z = snapshot.x(2, node);
      marker.points.push_back(point);
    }
  }
  return marker;
}

}  // namespace deformable_sim
