// Cloth with squares, seams and thickness: where each is, in metres.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/sheet_cut.h"
#include "deformable_sim/ros/body_drawing.h"
#include "ros/drawn_scene.h"

namespace deformable_sim {
namespace {

using visualization_msgs::Marker;

constexpr double kOwn = 0.5, kChecker = 0.9;  // red, of a body whose green tells the light

Vec3 position(const geometry_msgs::Point& p) {
  return {p.x, p.y, p.z};
}

double seam_area(const TriangleMesh& mesh, double width) {
  const SheetCut cut = cut_sheet(mesh, {0.0, width});
  const Nodes x = cut.extended(mesh.rest);
  double sum = 0.0;
  for (const SheetCut::Piece& piece : cut.pieces) {
    if (piece.paint != Paint::kSeam) continue;
    const Vec3 a = x.col(piece.corner[0]), b = x.col(piece.corner[1]), c = x.col(piece.corner[2]);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

/// A grey-green sheet with red squares. Green is 0.5 under every paint but seams'.
Body& add_painted_sheet(DrawnScene* scene, int cells, const SheetPattern& pattern, double thickness = 0.0) {
  Body& body = scene->add_sheet(cells);
  body.color = {{kOwn, 0.5, 0.5, 1.0}};
  auto look = std::make_shared<SheetLook>();
  look->checker_color = {{kChecker, 0.5, 0.5}};
  look->thickness = thickness;
  look->cut = cut_sheet(*body.surface, pattern);
  body.look = look;
  return body;
}

struct Triangle {
  Vec3 middle, normal;  // normal: as long as twice the area
  double red;           // over green: what is painted, without the light
  double green;         // the light, or the shade of a seam
};

std::vector<Triangle> triangles_of(const Marker& marker) {
  std::vector<Triangle> all;
  for (std::size_t i = 0; i + 2 < marker.points.size(); i += 3) {
    const Vec3 a = position(marker.points[i]), b = position(marker.points[i + 1]), c = position(marker.points[i + 2]);
    for (std::size_t k = i; k < i + 3; ++k) {
      EXPECT_NEAR(marker.colors[k].r / marker.colors[k].g, marker.colors[i].r / marker.colors[i].g, 1e-5);
    }
    all.push_back(
        {(a + b + c) / 3.0, (b - a).cross(c - a), marker.colors[i].r / marker.colors[i].g, marker.colors[i].g});
  }
  return all;
}

double area(const std::vector<Triangle>& triangles) {
  double sum = 0.0;
  for (const Triangle& triangle : triangles) sum += 0.5 * triangle.normal.norm();
  return sum;
}

TEST(Checker, AlternatesWithItsPeriodInMetresOnAnyCells) {
  // Of 1 x 1 m from (-0.5, -0.5) on: colour by floor((x + 0.5) / s) + floor((y + 0.5) / s). Squares are cut out of
  // coarse cells sharply: no triangle has a middle elsewhere than its colour says, and together they cover 1 m^2.
  for (const int cells : {1, 3, 10, 23}) {
    for (const double edge : {0.1, 0.15, 0.4}) {
      DrawnScene scene;
      add_painted_sheet(&scene, cells, {edge, 0.0});
      const std::vector<Triangle> triangles = triangles_of(body_marker(scene.snapshot, 0, OutputSpec()));
      EXPECT_NEAR(area(triangles), 1.0, 1e-9);
      double red = 0.0;
      for (const Triangle& t : triangles) {
        EXPECT_GT(t.normal.z(), 0.0);
        const int column = static_cast<int>((t.middle.x() + 0.5) / edge);
        const int row = static_cast<int>((t.middle.y() + 0.5) / edge);
        const bool odd = (column + row) % 2 != 0;
        EXPECT_NEAR(t.red, (odd ? kChecker : kOwn) / 0.5, 1e-4) << cells << " " << edge << " " << t.middle.transpose();
        red += odd ? 0.5 * t.normal.norm() : 0.0;
      }
      if (edge == 0.1) {
        EXPECT_NEAR(red, 0.5, 1e-9);
      }
    }
  }
}

TEST(Checker, CutsNothingWhereSquaresFollowTheCells) {
  DrawnScene scene;
  Body& body = add_painted_sheet(&scene, 10, {0.1, 0.0});
  EXPECT_EQ(body.look->cut.pieces.size(), 200u);
  EXPECT_EQ(body.look->cut.extras.size(), 0u);
}

TEST(Checker, MovesWithTheMaterial) {
  // Stretched by two and moved, squares are twice as long: paint belongs to the rest shape.
  DrawnScene scene;
  add_painted_sheet(&scene, 3, {0.25, 0.0});
  for (int node = 0; node < 16; ++node) scene.snapshot.x(0, node) = 2.0 * scene.snapshot.x(0, node) + 7.0;
  for (const Triangle& t : triangles_of(body_marker(scene.snapshot, 0, OutputSpec()))) {
    const int column = static_cast<int>((t.middle.x() - 6.0) / 0.5),
              row = static_cast<int>((t.middle.y() + 0.5) / 0.25);
    EXPECT_NEAR(t.red, ((column + row) % 2 != 0 ? kChecker : kOwn) / 0.5, 1e-4);
  }
}

TEST(Checker, IsHiddenWhereColoursTellValues) {
  DrawnScene scene;
  add_painted_sheet(&scene, 4, {0.1, 0.05});
  OutputSpec outputs;
  outputs.color_by = "velocity";
  for (const Triangle& t : triangles_of(body_marker(scene.snapshot, 0, outputs))) EXPECT_NEAR(t.red, 1.0, 1e-4);
}

TEST(Checker, RefusesMorePiecesThanThereMayBe) {
  const TriangleMesh mesh = make_grid(10.0, 10.0, 2, 2);
  EXPECT_THROW(cut_sheet(mesh, {0.001, 0.0}), InputError);
  EXPECT_THROW(cut_sheet(make_grid(1.0, 1.0, 500, 500), {0.0, 1.0}), InputError);
}

/// Whether light alone explains how dark it is: flat sheets are all lit alike.
bool is_seam(const Triangle& triangle, double lit) {
  return triangle.green < 0.8 * lit;
}

TEST(Seams, AreABandOfTheirWidthAlongTheBorder) {
  // A frame of 1 x 1 m, w wide: 1 - (1 - 2 w)^2, whether cells are wider than the band or narrower.
  for (const int cells : {1, 2, 7, 40}) {
    for (const double width : {0.03, 0.1}) {
      DrawnScene scene;
      add_painted_sheet(&scene, cells, {0.0, width});
      const std::vector<Triangle> triangles = triangles_of(body_marker(scene.snapshot, 0, OutputSpec()));
      EXPECT_NEAR(area(triangles), 1.0, 1e-9);
      double lit = 0.0, sum = 0.0;
      for (const Triangle& t : triangles) lit = std::max(lit, t.green);
      for (const Triangle& t : triangles) {
        const double inward = 0.5 - t.middle.head<2>().cwiseAbs().maxCoeff();
        EXPECT_EQ(is_seam(t, lit), inward < width) << cells << " " << t.middle.transpose();
        sum += is_seam(t, lit) ? 0.5 * t.normal.norm() : 0.0;
      }
      // A band's edge within 2 % of a line of the mesh is that line.
      EXPECT_NEAR(sum, 1.0 - std::pow(1.0 - 2.0 * width, 2), 0.02 * 4.0 * width);
    }
  }
}

TEST(Seams, RunWhereTwoPanelsMeetButNotAcrossThem) {
  // Two panels of 1 x 1 m, folded by a right angle at x = 0, which is no border: a band on both sides of it.
  TriangleMesh mesh;
  mesh.rest = (Nodes(3, 6) << 0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 1, 1).finished();
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 1, 5}, {0, 5, 4}};
  // Each panel has a frame all around.
  EXPECT_NEAR(seam_area(mesh, 0.1), 2.0 * (1.0 - 0.8 * 0.8), 1e-9);
  // With flat panels only the border is left: a frame of 2 x 1 m.
  mesh.rest.col(4) = Vec3(-1, 0, 0);
  mesh.rest.col(5) = Vec3(-1, 1, 0);
  EXPECT_NEAR(seam_area(mesh, 0.1), 2.0 - 1.8 * 0.8, 1e-9);
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = (p - a).dot(b - a) / (b - a).squaredNorm();
  return (p - a - std::clamp(t, 0.0, 1.0) * (b - a)).norm();
}

TEST(Seams, StayAtTheBorderInsideAReflexCorner) {
  // Three squares in an L, sheared, so that one edge of its inner corner leads into the other arm.
  TriangleMesh mesh = make_grid(2.0, 2.0, 2, 2);
  mesh.triangles.resize(6);
  mesh.rest.row(0) += 0.6 * mesh.rest.row(1);
  const double width = 0.1;
  const SheetCut cut = cut_sheet(mesh, {0.0, width});
  const Nodes x = cut.extended(mesh.rest);
  for (const SheetCut::Piece& piece : cut.pieces) {
    const Vec3 middle = (x.col(piece.corner[0]) + x.col(piece.corner[1]) + x.col(piece.corner[2])) / 3.0;
    double distance = 1e9;
    for (const SheetCut::Rim& rim : cut.rims) {
      distance = std::min(distance, distance_to_segment(middle, x.col(rim.end[0]), x.col(rim.end[1])));
    }
    if (piece.paint == Paint::kSeam) {
      EXPECT_LE(distance, std::sqrt(2.0) * width) << middle.transpose();
    } else {
      EXPECT_GE(distance, width) << middle.transpose();
    }
  }
}

TEST(Thickness, SetsTwoFacesApartAlongTheNormal) {
  // A sheet in a tilted plane: for every point of the upper face one of the lower is h away along the normal.
  const double h = 0.004;
  DrawnScene scene;
  add_painted_sheet(&scene, 3, {0.25, 0.0}, h);
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 0.5).normalized());
  for (int node = 0; node < 16; ++node) scene.snapshot.x.col(node) = turn * Vec3(scene.snapshot.x.col(node));
  const Vec3 normal = turn * Vec3::UnitZ();
  const Marker marker = body_marker(scene.snapshot, 0, OutputSpec());
  const std::size_t face = 3 * scene.model->bodies[0].look->cut.pieces.size();
  ASSERT_GT(marker.points.size(), 2 * face);
  for (std::size_t i = 0; i < face; ++i) {
    const Vec3 above = position(marker.points[i]), below = position(marker.points[face + i]);
    EXPECT_NEAR((above - below - h * normal).norm(), 0.0, 1e-8);
    EXPECT_NEAR(above.dot(normal), 0.5 * h, 1e-8);
  }
  // The strip closes it: 4 m of border, h wide, facing outwards.
  double strip = 0.0;
  for (std::size_t i = 2 * face; i < marker.points.size(); i += 3) {
    const Vec3 a = position(marker.points[i]), b = position(marker.points[i + 1]), c = position(marker.points[i + 2]);
    strip += 0.5 * (b - a).cross(c - a).norm();
    EXPECT_GT((b - a).cross(c - a).dot((a + b + c) / 3.0), 0.0);
  }
  EXPECT_NEAR(strip, 4.0 * h, 1e-9);
}

TEST(Thickness, OfASheetWithoutALookIsNone) {
  DrawnScene scene;
  scene.add_sheet(3);
  EXPECT_EQ(body_marker(scene.snapshot, 0, OutputSpec()).points.size(), 3u * 18u);
}

}  // namespace
}  // namespace deformable_sim
