#include "deformable_sim/ros/contact_drawing.h"

#include <algorithm>

#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/legend_drawing.h"

namespace deformable_sim {

namespace {

constexpr double kLongest = 0.2;  // of the scene
constexpr double kWidth = 0.003;  // of the scene
constexpr double kBarb = 0.2;     // of the arrow's length

double scene_size(const Snapshot& snapshot) {
  const auto [low, high] = starting_box(*snapshot.model);
  return (high - low).maxCoeff();
}

void add_arrow(const Vec3& from, const Vec3& arrow, visualization_msgs::Marker* marker) {
  const Vec3 tip = from + arrow, across = kBarb * 0.5 * arrow.norm() * arrow.unitOrthogonal();
  const Vec3 back = tip - kBarb * arrow;
  for (const Vec3& point : {from, tip, tip, Vec3(back + across), tip, Vec3(back - across)}) {
    marker->points.push_back(to_point(point));
  }
}

}  // namespace

double contact_arrow_scale(const Snapshot& snapshot, const OutputSpec& outputs) {
  if (outputs.contact_scale > 0.0) return outputs.contact_scale;
  double most = 0.0;
  for (const ContactReport& contact : snapshot.contacts) most = std::max(most, contact.force.norm());
  return most > 0.0 ? kLongest * scene_size(snapshot) / most : 1.0;
}

visualization_msgs::Marker contact_marker(const Snapshot& snapshot, int body, double scale) {
  visualization_msgs::Marker marker = blank_marker();
  marker.type = visualization_msgs::Marker::LINE_LIST;
  marker.scale.x = kWidth * scene_size(snapshot);
  marker.color.r = 0.85f;
  marker.color.g = 0.1f;
  marker.color.b = 0.45f;
  marker.color.a = 1.0f;
  for (const ContactReport& contact : snapshot.contacts) {
    if (contact.body == body) add_arrow(contact.point, scale * contact.force, &marker);
    if (contact.other == body) add_arrow(contact.point, -scale * contact.force, &marker);
  }
  return marker;
}

}  // namespace deformable_sim
