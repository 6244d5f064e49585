#include "deformable_sim/ros/sheet_drawing.h"

#include "deformable_sim/core/topology/sheet_cut.h"
#include "deformable_sim/ros/lit_triangles.h"
#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

constexpr float kSeamShade = 0.62f;

using Color = Eigen::Vector3f;

/// Colour before the light of a corner of a piece.
class PaintedColors {
 public:
  PaintedColors(const SheetLook& look, const std::vector<Color>& colors, Painting painting)
      : painting_(painting),
        checker_(static_cast<float>(look.checker_color[0]), static_cast<float>(look.checker_color[1]),
                 static_cast<float>(look.checker_color[2])),
        colors_(look.cut.extended(
            Eigen::Map<const Eigen::Matrix3Xf>(colors.front().data(), 3, static_cast<Eigen::Index>(colors.size())))) {}

  Color at(int corner, Paint paint) const {
    const Color own = colors_.col(corner);
    if (painting_ == Painting::kHidden) return own;
    return paint == Paint::kChecker ? checker_ : paint == Paint::kSeam ? Color(kSeamShade * own) : own;
  }

 private:
  Painting painting_;
  Color checker_;
  Eigen::Matrix3Xf colors_;
};

void draw_faces(const SheetLook& look, const PaintedColors& colors, const Nodes& x, const Eigen::Matrix3Xf& normals,
                visualization_msgs::Marker* marker) {
  const Light light;
  for (const SheetCut::Piece& piece : look.cut.pieces) {
    for (const int corner : piece.corner) {
      add_vertex(x.col(corner), light.on(normals.col(corner)) * colors.at(corner, piece.paint), marker);
    }
  }
}

void draw_rims(const SheetLook& look, const PaintedColors& colors, const Nodes& above, const Nodes& below,
               visualization_msgs::Marker* marker) {
  const Light light;
  for (const SheetCut::Rim& rim : look.cut.rims) {
    const auto [a, b] = rim.end;
    const Vec3 along = above.col(b) - above.col(a);
    const Vec3 out = along.cross(above.col(a) - below.col(a));
    const float lit = light.on(out.normalized().cast<float>());
    const auto vertex = [&](const Nodes& face, int end) {
      add_vertex(face.col(end), lit * colors.at(end, rim.paint), marker);
    };
    vertex(above, a);
    vertex(below, a);
    vertex(below, b);
    vertex(above, a);
    vertex(below, b);
    vertex(above, b);
  }
}

void draw_look(const SheetLook& look, const std::vector<Color>& colors, Painting painting, const ShownColumns& shown,
               const Eigen::Matrix3Xf& normals, visualization_msgs::Marker* marker) {
  const PaintedColors painted(look, colors, painting);
  const Nodes x = look.cut.extended(shown.all());
  Eigen::Matrix3Xf n = look.cut.extended(normals);
  const std::size_t faces = look.thickness > 0.0 ? 2 : 1;
  const std::size_t vertices = faces * 3 * look.cut.pieces.size() + (faces - 1) * 6 * look.cut.rims.size();
  marker->points.reserve(vertices);
  marker->colors.reserve(vertices);
  if (faces == 1) return draw_faces(look, painted, x, n, marker);
  const Nodes half = 0.5 * look.thickness * n.cast<double>();
  const Nodes above = x + half, below = x - half;
  draw_faces(look, painted, above, n, marker);
  draw_faces(look, painted, below, n, marker);
  draw_rims(look, painted, above, below, marker);
}

}  // namespace

void draw_sheet(const Snapshot& snapshot, const Body& body, std::vector<Color> colors, Painting painting,
                visualization_msgs::Marker* marker) {
  const ShownColumns x = shown_positions(snapshot, body);
  const Eigen::Matrix3Xf normals = shown_normals(snapshot, body, x);
  if (body.look) return draw_look(*body.look, colors, painting, x, normals, marker);
  const Light light;
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] *= light.on(normals.col(static_cast<Eigen::Index>(i)));
  const std::vector<std::array<int, 3>>& triangles = shown_surface(body)->triangles;
  marker->points.reserve(3 * triangles.size());
  marker->colors.reserve(3 * triangles.size());
  for (const std::array<int, 3>& triangle : triangles) {
    for (const int point : triangle) add_vertex(x.col(point), colors[static_cast<std::size_t>(point)], marker);
  }
}

}  // namespace deformable_sim
