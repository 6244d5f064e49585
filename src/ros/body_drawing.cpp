#include "deformable_sim/ros/body_drawing.h"

#include "deformable_sim/ros/body_colors.h"
#include "deformable_sim/ros/rope_drawing.h"
#include "deformable_sim/ros/sheet_drawing.h"
#include "deformable_sim/ros/shown_body.h"
#include "deformable_sim/ros/solid_drawing.h"

namespace deformable_sim {

namespace {

constexpr double kLineWidth = 5e-4;   // m
constexpr double kFrameWidth = 1e-3;  // m

visualization_msgs::Marker line_list(double width) {
  visualization_msgs::Marker marker = blank_marker();
  marker.type = visualization_msgs::Marker::LINE_LIST;
  marker.scale.x = width;
  marker.color.r = marker.color.g = marker.color.b = 0.1f;
  marker.color.a = 1.0f;
  return marker;
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
  const std::vector<Color> colors = body_colors(snapshot, shape, outputs);
  if (!shown_surface(shape)) {
    draw_tube(snapshot, shape, colors, &marker);
  } else if (shape.volume) {
    draw_solid(*shown_surface(shape), shown_positions(snapshot, shape), colors, &marker);
  } else {
    draw_sheet(snapshot, shape, colors, outputs.color_by == "body" ? Painting::kShown : Painting::kHidden, &marker);
  }
  return marker;
}

visualization_msgs::Marker wireframe_marker(const Snapshot& snapshot, int body) {
  visualization_msgs::Marker marker = line_list(kLineWidth);
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

visualization_msgs::Marker frames_marker(const Snapshot& snapshot, int body) {
  visualization_msgs::Marker marker = line_list(kFrameWidth);
  draw_frames(snapshot, snapshot.model->bodies[body], &marker);
  return marker;
}

}  // namespace deformable_sim
