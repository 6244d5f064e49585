// What a camera sees of a snapshot, what it publishes of that, and which parameters it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include <xmlrpcpp/XmlRpcValue.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/camera/camera_messages.h"
#include "deformable_sim/ros/camera/camera_parameters.h"
#include "deformable_sim/ros/camera/camera_view.h"

namespace deformable_sim {
namespace {

constexpr double kCameraHeight = 1.0;  // m
constexpr std::uint16_t kSheet = 1, kRope = 2, kFirstCollider = 3;

Pinhole small_camera() {
  Pinhole camera;
  camera.width = 80;
  camera.height = 60;
  camera.fx = 90.0;
  camera.fy = 70.0;
  camera.cx = 41.2;
  camera.cy = 28.4;
  return camera;
}

/// Looks straight down from above (x0, y0): the image's right is the world's x, its down the world's -y.
Pose from_above(double x0, double y0) {
  Pose pose = Pose::Identity();
  pose.linear().col(0) = Vec3(1, 0, 0);
  pose.linear().col(1) = Vec3(0, -1, 0);
  pose.linear().col(2) = Vec3(0, 0, -1);
  pose.translation() = Vec3(x0, y0, kCameraHeight);
  return pose;
}

Collider make(const std::string& name, Shape::Type type, const Vec3& size, const Vec3& at) {
  Collider collider;
  collider.name = name;
  Shape shape;
  shape.type = type;
  shape.size = size;
  // Half of the way by the shape, half by the collider, turned against one another: both poses count.
  const Mat3 turn = Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitZ()).toRotationMatrix();
  collider.world_from_collider.linear() = turn;
  collider.world_from_collider.translation() = 0.5 * at;
  shape.collider_from_shape.linear() = turn.transpose();
  shape.collider_from_shape.translation() = turn.transpose() * (0.5 * at);
  collider.shapes.push_back(shape);
  return collider;
}

/// A sheet of 0.3 m at height z around the origin, and a rope of radius 10 mm along y, 0.3 m beside it.
Snapshot sheet_and_rope(double z) {
  auto model = std::make_shared<Model>();
  const TriangleMesh grid = make_grid(0.3, 0.3, 6, 6);
  const Polyline line = make_line(0.4, 4);
  Body sheet, rope;
  sheet.name = "sheet";
  sheet.node_count = static_cast<int>(grid.rest.cols());
  sheet.surface = std::make_shared<TriangleMesh>(grid);
  rope.name = "rope";
  rope.kind = BodyKind::kRope;
  rope.first_node = sheet.node_count;
  rope.node_count = static_cast<int>(line.rest.cols());
  rope.line = std::make_shared<Polyline>(line);
  rope.draw_radius = 0.01;
  model->bodies = {sheet, rope};
  Snapshot snapshot;
  snapshot.x.resize(3, sheet.node_count + rope.node_count);
  const Vec3 middle = 0.5 * (grid.rest.rowwise().minCoeff() + grid.rest.rowwise().maxCoeff());
  snapshot.x.leftCols(sheet.node_count) = grid.rest.colwise() + (Vec3(0, 0, z) - middle);
  for (int i = 0; i < rope.node_count; ++i) snapshot.x.col(rope.first_node + i) << 0.3, -0.2 + 0.1 * i, z;
  snapshot.v = Nodes::Zero(3, snapshot.x.cols());
  model->mass = Eigen::VectorXd::Ones(snapshot.x.cols());
  snapshot.model = model;
  return snapshot;
}

struct Picture {
  DepthBuffer buffer{small_camera()};
  std::vector<float> depth;

  Picture(const Snapshot& snapshot, const Pose& world_from_camera) {
    SegmentIds ids;
    draw_world(snapshot, ids.of(snapshot), world_from_camera, &buffer);
    depth = buffer.depth();
  }

  /// Compares all pixels with `expected(x, y, label)`, the height of what is seen along the line of sight that meets
  /// the ground at x, y (m, from below the camera); float32 and nothing else: 1e-6 m.
  template <class Height>
  void expect(const Height& expected) const {
    const Pinhole& camera = buffer.camera();
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const std::size_t pixel = static_cast<std::size_t>(v * camera.width + u);
        int label = 0;
        const double height = expected((u - camera.cx) / camera.fx, -(v - camera.cy) / camera.fy, &label);
        ASSERT_EQ(buffer.labels()[pixel], label) << u << " " << v;
        if (label != 0) {
          ASSERT_NEAR(depth[pixel], kCameraHeight - height, 1e-6) << u << " " << v;
        } else {
          ASSERT_TRUE(std::isnan(depth[pixel])) << u << " " << v;
        }
      }
    }
  }

  int count(int label) const {
    return static_cast<int>(std::count(buffer.labels().begin(), buffer.labels().end(), label));
  }
};

/// Whether the line of sight to (x, y) on the ground passes the square of half an edge `half` at height z.
bool in_square(double x, double y, double z, double half) {
  const double part = (kCameraHeight - z) / kCameraHeight;
  return std::abs(part * x) <= half && std::abs(part * y) <= half;
}

/// Depth of the sphere around (cx, cy, cz) on the line of sight from the camera above the origin; NaN beside it.
double sphere_depth(const Vec3& c, double r, double x, double y) {
  const Vec3 from(0, 0, kCameraHeight), e = Vec3(x, y, -kCameraHeight).normalized();
  const double along = e.dot(c - from), root = r * r - (c - from).squaredNorm() + along * along;
  return root < 0.0 ? std::numeric_limits<double>::quiet_NaN() : -(along - std::sqrt(root)) * e.z();
}

TEST(CameraView, ShowsClothBeforeATable) {
  // A sheet at z = 0.4 above a plane at z = 0.1: heights are those, the sheet's outline its perspective square.
  Snapshot snapshot = sheet_and_rope(0.4);
  snapshot.colliders = {make("table", Shape::Type::kPlane, Vec3::Zero(), {0, 0, 0.1})};
  snapshot.x.rightCols(5).row(0).setConstant(50.0);  // the rope is elsewhere
  Picture(snapshot, from_above(0, 0)).expect([](double x, double y, int* label) {
    const bool cloth = in_square(x, y, 0.4, 0.15);
    *label = cloth ? kSheet : kFirstCollider;
    return cloth ? 0.4 : 0.1;
  });
}

TEST(CameraView, ShowsAnObstacleBeforeClothAndClothBeforeAnObstacle) {
  // A sphere pushed half through the sheet: whichever is nearer along each line of sight.
  Snapshot snapshot = sheet_and_rope(0.4);
  const Vec3 c(0.02, -0.01, 0.38);
  snapshot.colliders = {make("ball", Shape::Type::kSphere, {0.06, 0, 0}, c)};
  snapshot.x.rightCols(5).row(0).setConstant(50.0);
  const Picture picture(snapshot, from_above(0, 0));
  picture.expect([&](double x, double y, int* label) {
    const double ball = sphere_depth(c, 0.06, x, y);
    if (in_square(x, y, 0.4, 0.15)) {
      *label = ball < 0.6 ? kFirstCollider : kSheet;
      return ball < 0.6 ? 1.0 - ball : 0.4;
    }
    *label = 0;
    return 0.0;
  });
  EXPECT_GT(picture.count(kSheet), 100);
  EXPECT_GT(picture.count(kFirstCollider), 20);
  snapshot.x.row(2).array() += 0.1;  // now all of the ball is below the sheet
  EXPECT_EQ(Picture(snapshot, from_above(0, 0)).count(kFirstCollider), 0);
}

TEST(CameraView, ShowsARopeAsATube) {
  // Right above a rope of radius 10 mm along y: its top is nearest; its width in a row that meets it is
  // 2 r / sqrt(D^2 - r^2) in slopes, D = 0.6 m.
  const Picture picture(sheet_and_rope(0.4), from_above(0.3, 0));
  const Pinhole camera = small_camera();
  const auto row = static_cast<std::size_t>(28 * camera.width);
  float least = 10.0f;
  int width = 0;
  for (std::size_t u = 0; u < static_cast<std::size_t>(camera.width); ++u) {
    if (picture.buffer.labels()[row + u] != kRope) continue;
    ++width;
    least = std::min(least, picture.depth[row + u]);
  }
  EXPECT_NEAR(least, 0.59, 1e-4);  // a pixel at most half a pixel, 3 mm, beside the middle
  EXPECT_NEAR(width, camera.fx * 0.02 / std::sqrt(0.36 - 1e-4), 1.0);
}

TEST(CameraView, HasTheImageUprightForAnOpticalFrame) {
  // A ball towards +x of the world is on the right, one towards +y is above the middle.
  Snapshot snapshot = sheet_and_rope(-50.0);
  snapshot.colliders = {make("right", Shape::Type::kSphere, {0.02, 0, 0}, {0.2, 0, 0.2}),
                        make("above", Shape::Type::kSphere, {0.02, 0, 0}, {0, 0.2, 0.2})};
  const Picture picture(snapshot, from_above(0, 0));
  const Pinhole camera = small_camera();
  const auto label = [&](double u, double v) {
    return picture.buffer.labels()[static_cast<std::size_t>(std::lround(v) * camera.width + std::lround(u))];
  };
  EXPECT_EQ(label(camera.cx + camera.fx * 0.25, camera.cy), kFirstCollider);
  EXPECT_EQ(label(camera.cx, camera.cy - camera.fy * 0.25), kFirstCollider + 1);
}

TEST(SegmentIds, StayWithTheNamesWhateverComesAndGoes) {
  // Bodies 1, 2; obstacles by when they were first seen.
  Snapshot snapshot = sheet_and_rope(0.0);
  const Collider a = make("a", Shape::Type::kSphere, {1, 0, 0}, Vec3::Zero());
  Collider b = a, c = a;
  b.name = "b";
  c.name = "c";
  SegmentIds ids;
  using List = std::vector<std::uint16_t>;
  snapshot.colliders = {a, b};
  EXPECT_EQ(ids.of(snapshot).colliders, (List{3, 4}));
  EXPECT_EQ(ids.of(snapshot).bodies, (List{1, 2}));
  snapshot.colliders = {c, b};
  EXPECT_EQ(ids.of(snapshot).colliders, (List{5, 4}));
  snapshot.colliders = {a, c};
  const SegmentIds::OfSnapshot again = ids.of(snapshot);
  EXPECT_EQ(again.colliders, (List{3, 5}));
  const msg::SegmentLabels labels = segment_labels(snapshot, again);
  EXPECT_EQ(labels.label, (List{1, 2, 3, 5}));
  EXPECT_EQ(labels.name, (std::vector<std::string>{"sheet", "rope", "a", "c"}));
}

TEST(CameraMessages, AgreeWithOneAnother) {
  // x = z (u - cx) / fx, y = z (v - cy) / fy with K of the camera info and z of the image; NaN stays NaN.
  const Pinhole camera = small_camera();
  std::vector<float> depth(80 * 60, 1.0f);
  std::vector<std::uint16_t> labels(80 * 60, 3);
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = 0.5f + 1e-4f * static_cast<float>(i);
  depth[81] = std::numeric_limits<float>::quiet_NaN();
  labels[81] = 0;
  const sensor_msgs::CameraInfo info = camera_info(camera);
  const sensor_msgs::Image image = depth_image(camera, depth), segmentation = segmentation_image(camera, labels);
  const sensor_msgs::PointCloud2 cloud = camera_cloud(camera, depth, labels);
  EXPECT_EQ(info.width, 80u);
  EXPECT_EQ(info.height, 60u);
  EXPECT_EQ(info.K[0], 90.0);
  EXPECT_EQ(info.P[5], 70.0);
  EXPECT_EQ(image.encoding, "32FC1");
  EXPECT_EQ(image.step, 320u);
  EXPECT_EQ(segmentation.encoding, "16UC1");
  EXPECT_EQ(segmentation.step, 160u);
  EXPECT_EQ(cloud.row_step * cloud.height, cloud.data.size());
  for (std::size_t v = 0; v < 60; ++v) {
    for (std::size_t u = 0; u < 80; ++u) {
      struct {
        float x, y, z;
        std::uint32_t label;
      } point;
      float z = 0.0f;
      std::uint16_t label = 0;
      std::memcpy(&point, &cloud.data[v * cloud.row_step + u * cloud.point_step], sizeof point);
      std::memcpy(&z, &image.data[v * image.step + u * 4], sizeof z);
      std::memcpy(&label, &segmentation.data[v * segmentation.step + u * 2], sizeof label);
      ASSERT_EQ(point.label, label);
      if (u == 1 && v == 1) {
        ASSERT_TRUE(std::isnan(z) && std::isnan(point.x) && std::isnan(point.y) && std::isnan(point.z));
        continue;
      }
      ASSERT_EQ(point.z, z);
      ASSERT_NEAR(point.x, z * (static_cast<double>(u) - info.K[2]) / info.K[0], 1e-6);
      ASSERT_NEAR(point.y, z * (static_cast<double>(v) - info.K[5]) / info.K[4], 1e-6);
    }
  }
}

XmlRpc::XmlRpcValue good_camera() {
  XmlRpc::XmlRpcValue camera;
  camera["frame"] = "eye_optical_frame";
  camera["width"] = 100;
  camera["height"] = 50;
  camera["hfov"] = 2.0 * std::atan(0.5);
  return camera;
}

TEST(CameraParameters, TakeAnAngleOrFocalLengths) {
  // fx = width / 2 / tan(hfov / 2); square pixels and the centre of the image if nothing else is said.
  XmlRpc::XmlRpcValue value;
  value["b"] = good_camera();
  value["a"] = good_camera();
  value["a"]["far"] = 20;
  value["a"]["noise"]["sigma"] = 0.001;
  value["a"]["noise"]["seed"] = 4;
  const std::vector<CameraParameters> cameras = to_cameras(value);
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[0].name, "a");
  EXPECT_EQ(cameras[0].pinhole.far, 20.0);
  EXPECT_EQ(cameras[0].noise.sigma, 0.001);
  EXPECT_EQ(cameras[0].noise.seed, 4u);
  EXPECT_EQ(cameras[1].frame, "eye_optical_frame");
  EXPECT_NEAR(cameras[1].pinhole.fx, 100.0, 1e-12);
  EXPECT_NEAR(cameras[1].pinhole.fy, 100.0, 1e-12);
  EXPECT_EQ(cameras[1].pinhole.cx, 49.5);
  EXPECT_EQ(cameras[1].pinhole.cy, 24.5);
  EXPECT_FALSE(cameras[1].noise.any());
}

/// What is said of {eye: camera}; empty when it is accepted.
std::string refusal(const XmlRpc::XmlRpcValue& camera, const std::string& name = "eye") {
  XmlRpc::XmlRpcValue cameras;
  cameras[name] = camera;
  try {
    to_cameras(cameras);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CameraParameters, AreRefusedByName) {
  EXPECT_EQ(refusal(good_camera()), "");
  const struct {
    const char* key;
    XmlRpc::XmlRpcValue value;
    const char* word;
  } cases[] = {
      {"frame", "", "~cameras/eye/frame"},
      {"frame", "/eye", "leading slash"},
      {"frame", 5, "a string"},
      {"width", 0, "1 ... 4096"},
      {"width", 100.5, "whole number"},
      {"height", 5000, "~cameras/eye/height"},
      {"hfov", 3.2, "~cameras/eye/hfov"},
      {"hfov", "wide", "a number"},
      {"hfov", std::numeric_limits<double>::quiet_NaN(), "~cameras/eye/hfov"},
      {"fx", 500.0, "hfov and fx"},
      {"fy", 0.0, "~cameras/eye/fy"},
      {"cx", 1e9, "~cameras/eye/cx"},
      {"near", 0.0, "~cameras/eye/near"},
      {"near", 10.0, "less than far"},
      {"far", -1.0, "~cameras/eye/far"},
      {"rate", -1.0, "0 ... 1000"},
      {"fov", 1.0, "~cameras/eye/fov"},
      {"noise", 0.1, "~cameras/eye/noise"},
  };
  for (const auto& c : cases) {
    XmlRpc::XmlRpcValue camera = good_camera();
    camera[c.key] = c.value;
    EXPECT_NE(refusal(camera).find(c.word), std::string::npos) << c.key << ": " << refusal(camera);
  }
  const struct {
    const char* key;
    XmlRpc::XmlRpcValue value;
  } noises[] = {{"sigma", -0.1},         {"sigma_growth", "a lot"}, {"sigma_distance", -1.0}, {"baseline", 11.0},
                {"disparity_step", 0.0}, {"grazing_angle", 1.6},    {"dropout", 1.1},         {"seed", -1},
                {"stddev", 0.1}};
  for (const auto& c : noises) {
    XmlRpc::XmlRpcValue camera = good_camera();
    camera["noise"][c.key] = c.value;
    const std::string path = std::string("~cameras/eye/noise/") + c.key;
    EXPECT_NE(refusal(camera).find(path), std::string::npos) << path << ": " << refusal(camera);
  }
  XmlRpc::XmlRpcValue blind;
  blind["frame"] = "eye";
  EXPECT_NE(refusal(blind).find("hfov (rad) or fx"), std::string::npos) << refusal(blind);
  EXPECT_NE(refusal(5).find("~cameras/eye"), std::string::npos);
  EXPECT_NE(refusal(good_camera(), "left eye").find("left eye"), std::string::npos);
  EXPECT_THROW(to_cameras(XmlRpc::XmlRpcValue(5)), InputError);
}

}  // namespace
}  // namespace deformable_sim
