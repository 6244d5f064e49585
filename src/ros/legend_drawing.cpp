#include "deformable_sim/ros/legend_drawing.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "deformable_sim/ros/body_colors.h"
#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/lit_triangles.h"
#include "deformable_sim/ros/rigid_drawing.h"

namespace deformable_sim {

namespace {

using visualization_msgs::Marker;

constexpr int kBands = 24;
constexpr double kWidth = 0.08;     // of the bar's height
constexpr double kLetter = 0.11;    // likewise
constexpr double kSmallest = 0.05;  // m, the bar's height by itself

Marker bar(const ColorScale& scale, const Vec3& foot, double height) {
  Marker marker = blank_marker();
  marker.type = Marker::TRIANGLE_LIST;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.color.a = 1.0f;
  const double half = 0.5 * kWidth * height;
  const std::array<Vec3, 5> corners{
      {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}, {-half, -half, 0}}};
  const double lowest = scale.low < 0.0 ? -1.0 : 0.0;
  for (int band = 0; band < kBands; ++band) {
    const Color color = scale_color(static_cast<float>(lowest + (1.0 - lowest) * (band + 0.5) / kBands));
    const Vec3 low = foot + Vec3(0, 0, height * band / kBands), high = foot + Vec3(0, 0, height * (band + 1) / kBands);
    for (std::size_t side = 0; side < 4; ++side) {
      const Vec3 &a = corners[side], &b = corners[side + 1];
      for (const Vec3& at :
           {Vec3(low + a), Vec3(low + b), Vec3(high + b), Vec3(low + a), Vec3(high + b), Vec3(high + a)}) {
        add_vertex(at, color, &marker);
      }
    }
  }
  return marker;
}

Marker text(const std::string& words, const Vec3& at, double letter) {
  Marker marker = blank_marker();
  marker.type = Marker::TEXT_VIEW_FACING;
  marker.pose.position = to_point(at);
  marker.scale.z = letter;
  marker.color.r = kLetterColor[0];
  marker.color.g = kLetterColor[1];
  marker.color.b = kLetterColor[2];
  marker.color.a = 1.0f;
  marker.text = words;
  return marker;
}

}  // namespace

std::string number_text(double value, const std::string& unit) {
  if (value == 0.0) return "0";
  double shown = value;
  std::string prefix;
  for (const char* next : {"k", "M", "G"}) {
    if (unit.empty() || std::abs(shown) < 999.5) break;
    shown /= 1000.0;
    prefix = next;
  }
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g", shown);
  return unit.empty() ? digits : std::string(digits) + " " + prefix + unit;
}

std::array<Vec3, 2> starting_box(const Model& model) {
  const auto points = model.initial.x.leftCols(model.point_count());
  if (points.cols() == 0) return {Vec3::Zero(), Vec3::Zero()};
  return {Vec3(points.rowwise().minCoeff()), Vec3(points.rowwise().maxCoeff())};
}

std::vector<Marker> legend_markers(const Snapshot& snapshot, const OutputSpec& outputs) {
  const ColorScale scale = color_scale(snapshot, outputs);
  if (scale.quantity.empty()) return {};
  const auto [low, high] = starting_box(*snapshot.model);
  const double size = (high - low).maxCoeff();
  const double height = outputs.legend_height > 0.0 ? outputs.legend_height : std::max(0.5 * size, kSmallest);
  const Vec3 beside(low.x() - 0.1 * size, high.y() + 0.1 * size, low.z());
  const Vec3 foot = outputs.legend_position.value_or(beside);
  const double letter = kLetter * height;
  // Numbers stand away from the bodies, on the side that is theirs.
  const Vec3 aside = foot + Vec3(-1, 1, 0).normalized() * 3.0 * letter;
  std::vector<Marker> markers{bar(scale, foot, height)};
  for (const double part : {0.0, 0.5, 1.0}) {
    const double value = scale.low + part * (scale.high - scale.low);
    markers.push_back(text(number_text(value, scale.unit), aside + Vec3(0, 0, part * height), letter));
  }
  markers.push_back(text(scale.quantity, foot + Vec3(0, 0, height + 1.5 * letter), letter));
  for (std::size_t i = 0; i < markers.size(); ++i) {
    markers[i].ns = "legend";
    markers[i].id = static_cast<int>(i);
  }
  return markers;
}

}  // namespace deformable_sim
