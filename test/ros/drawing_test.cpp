// What clouds and markers show of a snapshot: skins in place of nodes, colours, the material frames of rods.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <set>
#include <tuple>

#include "deformable_sim/core/contact/voxel_solid.h"
#include "deformable_sim/ros/body_colors.h"
#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/point_cloud.h"
#include "deformable_sim/ros/rigid_drawing.h"
#include "deformable_sim/ros/shown_body.h"
#include "ros/drawn_scene.h"

namespace deformable_sim {
namespace {

struct CloudPoint {
  float x[3], normal[3], v[3], strain;
  std::uint32_t node, body;
};

CloudPoint point_of(const sensor_msgs::PointCloud2& cloud, int index) {
  CloudPoint point{};
  std::memcpy(&point, cloud.data.data() + static_cast<std::size_t>(index) * cloud.point_step, cloud.point_step);
  return point;
}

OutputSpec colored_by(const std::string& what) {
  OutputSpec outputs;
  outputs.color_by = what;
  return outputs;
}

TEST(PointCloud, OfAnUpsampledGridIsOrganisedAndFiner) {
  DrawnScene scene;
  Body& body = scene.add_sheet(4);
  body.skin = make_upsampled_skin(*body.surface, 3);
  scene.snapshot.x.row(2).setRandom();
  scene.snapshot.v.setRandom();
  const sensor_msgs::PointCloud2 cloud = body_cloud(scene.snapshot, 0);
  ASSERT_EQ(std::make_tuple(cloud.height, cloud.width, cloud.point_step), std::make_tuple(13u, 13u, 44u));
  // Every third point of every third row is a node.
  for (int row = 0; row < 5; ++row) {
    for (int col = 0; col < 5; ++col) {
      const CloudPoint point = point_of(cloud, 3 * row * 13 + 3 * col);
      const int node = row * 5 + col;
      EXPECT_EQ(point.node, static_cast<std::uint32_t>(node));
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(point.x[axis], scene.snapshot.x(axis, node), 1e-6);
        EXPECT_NEAR(point.v[axis], scene.snapshot.v(axis, node), 1e-6);
      }
      EXPECT_NEAR(std::hypot(point.normal[0], point.normal[1], point.normal[2]), 1.0, 1e-5);
    }
  }
}

TEST(PointCloud, OfAllBodiesHasNoAnglesOfRods) {
  DrawnScene scene;
  Body& body = scene.add_sheet(2);
  body.skin = make_upsampled_skin(*body.surface, 2);
  scene.add_rod(4, 0.0);
  const sensor_msgs::PointCloud2 cloud = world_cloud(scene.snapshot);
  ASSERT_EQ(cloud.width, 25u + 5u);
  ASSERT_EQ(cloud.data.size(), cloud.width * 48u);
  for (int p = 0; p < 30; ++p) EXPECT_LT(std::abs(point_of(cloud, p).x[0]), 1.0f);
  EXPECT_EQ(point_of(cloud, 29).node, 4u);
  EXPECT_EQ(point_of(cloud, 29).body, 1u);
}

TEST(PointCloud, OfASoftBodyHasNormalsOnItsSurfaceOnly) {
  // A tetrahedron with a fifth node inside.
  DrawnScene scene;
  TriangleMesh surface;
  surface.rest = (Nodes(3, 5) << 0, 1, 0, 0, 0.2, 0, 0, 1, 0, 0.2, 0, 0, 0, 1, 0.2).finished();
  surface.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  Body& body = scene.add("soft", surface.rest);
  body.kind = BodyKind::kSoft;
  body.surface = std::make_shared<TriangleMesh>(surface);
  body.volume = std::make_shared<TetMesh>();
  const sensor_msgs::PointCloud2 cloud = body_cloud(scene.snapshot, 0);
  ASSERT_EQ(cloud.width, 5u);
  for (int p = 0; p < 5; ++p) {
    const CloudPoint point = point_of(cloud, p);
    EXPECT_NEAR(std::hypot(point.normal[0], point.normal[1], point.normal[2]), p < 4 ? 1.0 : 0.0, 1e-5);
  }
  EXPECT_EQ(body_marker(scene.snapshot, 0, OutputSpec()).points.size(), 12u);
}

TEST(BodyMarker, ShowsTheSkin) {
  DrawnScene scene;
  Body& body = scene.add_sheet(2);
  EXPECT_EQ(body_marker(scene.snapshot, 0, OutputSpec()).points.size(), 3u * 8u);
  body.skin = make_upsampled_skin(*body.surface, 4);
  const visualization_msgs::Marker marker = body_marker(scene.snapshot, 0, OutputSpec());
  EXPECT_EQ(marker.points.size(), 3u * 8u * 16u);
  EXPECT_EQ(marker.colors.size(), marker.points.size());
}

TEST(BodyMarker, KeepsTheEdgesOfASolidSharp) {
  // A cube: every corner of a face is lit as the face is, though the mean normal there is 55 degrees off. As a sheet
  // the same triangles would be rounded.
  DrawnScene scene;
  const TetMesh cube = make_box(Vec3::Ones(), {1, 1, 1});
  Body& body = scene.add("cube", cube.rest);
  body.surface = std::make_shared<TriangleMesh>(boundary_of(cube));
  const auto shades = [&] {
    std::set<int> found;
    for (const auto& color : body_marker(scene.snapshot, 0, OutputSpec()).colors) {
      found.insert(static_cast<int>(std::lround(1e4 * color.r)));
    }
    return found.size();
  };
  EXPECT_GT(shades(), 3u);
  body.volume = std::make_shared<TetMesh>(cube);
  EXPECT_EQ(shades(), 3u);  // from either side alike
}

TEST(BodyColors, SaturateToMagentaWhereTheLawNoLongerHolds) {
  // The right half is stretched by 10 %, past a limit of 5 %; the colour of strain_range 0.2 alone would be pink.
  DrawnScene scene;
  Body& body = scene.add_sheet(4);
  OutputSpec outputs = colored_by("strain");
  outputs.strain_range = 0.2;
  for (int node = 0; node < 25; ++node) {
    double& x = scene.snapshot.x(0, node);
    if (x > 0.0) x *= 1.1;
  }
  const Color magenta(1.0f, 0.0f, 0.9f);
  const auto count = [&] {
    int beyond = 0;
    for (const Color& color : body_colors(scene.snapshot, body, outputs)) beyond += color == magenta ? 1 : 0;
    return beyond;
  };
  EXPECT_EQ(count(), 0);
  body.valid_strain = {-1e9, 0.05};
  EXPECT_EQ(count(), 15);
  body.valid_strain = {-0.2, 0.15};
  EXPECT_EQ(count(), 0);
  body.valid_strain = {-1e9, 0.05};
  body.skin = make_upsampled_skin(*body.surface, 2);
  // Columns 3 ... 8 of 0 ... 8 have their nearest node there (3 lies half way, and goes to either).
  EXPECT_GE(count(), 5 * 9);
  EXPECT_LE(count(), 6 * 9);
}

TEST(BodyColors, EvaluateStressOnlyToShowIt) {
  // ... and with the body's own nodes, here the last four of seven.
  DrawnScene scene;
  scene.add("other", Nodes::Zero(3, 3));
  Body& body = scene.add_sheet(1);
  int asked = 0;
  body.stress = [&asked](const Nodes& x) {
    ++asked;
    EXPECT_EQ(x.cols(), 4);
    return Eigen::VectorXf((Eigen::VectorXf(4) << 0.0f, 1e6f, -1e6f, 5e6f).finished());
  };
  for (const char* other : {"body", "strain", "velocity", "contact"}) {
    body_colors(scene.snapshot, body, colored_by(other));
  }
  EXPECT_EQ(asked, 0);
  OutputSpec outputs = colored_by("stress");
  outputs.stress_range = 1e6;
  const std::vector<Color> colors = body_colors(scene.snapshot, body, outputs);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(colors[0], Color(0.85f, 0.85f, 0.85f));
  EXPECT_GT(colors[1].x(), 0.9f);
  EXPECT_LT(colors[1].z(), 0.1f);
  EXPECT_GT(colors[2].z(), 0.9f);
  EXPECT_EQ(colors[3], colors[1]);
  body.stress = nullptr;
  EXPECT_EQ(body_colors(scene.snapshot, body, outputs)[1], Color(0.85f, 0.85f, 0.85f));
}

TEST(Frames, AreTheTwoDirectorsOfEachSegment) {
  DrawnScene scene;
  scene.add_rod(5, 0.7);
  const visualization_msgs::Marker marker = frames_marker(scene.snapshot, 0);
  EXPECT_EQ(marker.type, visualization_msgs::Marker::LINE_LIST);
  ASSERT_EQ(marker.points.size(), 5u * 4u);
  ASSERT_EQ(marker.colors.size(), marker.points.size());
  const auto at = [&](std::size_t i) { return Vec3(marker.points[i].x, marker.points[i].y, marker.points[i].z); };
  for (std::size_t s = 0; s < 5; ++s) {
    EXPECT_NEAR((at(4 * s) - Vec3(-0.4 + 0.2 * static_cast<double>(s), 0, 0)).norm(), 0.0, 1e-6);
    const Vec3 first = at(4 * s + 1) - at(4 * s), second = at(4 * s + 3) - at(4 * s + 2);
    EXPECT_NEAR((first - 0.2 * Vec3(0, std::cos(0.7), std::sin(0.7))).norm(), 0.0, 1e-6);
    EXPECT_NEAR((second - 0.2 * Vec3(0, -std::sin(0.7), std::cos(0.7))).norm(), 0.0, 1e-6);
  }
}

TEST(ColliderDrawing, ShowsVoxelsAsCubesOfTheirSizes) {
  // Two cells of 0.1 m, and a cube of 0.2 m; where each begins is (key - 32768) times 0.1 m, its middle half a size on.
  const auto key = [](int k) { return static_cast<std::uint16_t>(kVoxelOrigin + k); };
  Collider collider;
  collider.name = "map";
  collider.shapes.resize(1);
  collider.shapes[0].type = Shape::Type::kVoxels;
  collider.shapes[0].voxels = std::make_shared<const VoxelSolid>(
      std::vector<VoxelCube>{
          {{{key(0), key(0), key(0)}}, 0}, {{{key(-2), key(0), key(4)}}, 1}, {{{key(1), key(1), key(1)}}, 0}},
      0.1);
  const auto markers = collider_markers(collider);
  ASSERT_EQ(markers.size(), 2u);
  for (const auto& marker : markers) EXPECT_EQ(marker.type, visualization_msgs::Marker::CUBE_LIST);
  EXPECT_NEAR(markers[0].scale.x, 0.1, 1e-12);
  EXPECT_EQ(markers[0].points.size(), 2u);
  EXPECT_NEAR(markers[1].scale.z, 0.2, 1e-12);
  ASSERT_EQ(markers[1].points.size(), 1u);
  EXPECT_NEAR(markers[1].points[0].x, -0.1, 1e-12);
  EXPECT_NEAR(markers[1].points[0].y, 0.1, 1e-12);
  EXPECT_NEAR(markers[1].points[0].z, 0.5, 1e-12);
}

}  // namespace
}  // namespace deformable_sim
