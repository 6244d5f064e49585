// Depth images of single things against closed forms, to 1e-6 of the depth: that is float32 and nothing more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/camera/depth_buffer.h"
#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/topology/triangle_mesh.h"
#include "support/collider_meshes.h"
#include "support/voxels.h"

namespace deformable_sim {
namespace {

/// Neither square nor centred, so that no two of its numbers can be mistaken for one another.
Pinhole small_camera() {
  Pinhole camera;
  camera.width = 120;
  camera.height = 90;
  camera.fx = 100.0;
  camera.fy = 80.0;
  camera.cx = 61.3;
  camera.cy = 40.2;
  return camera;
}

Shape make(Shape::Type type, const Vec3& size) {
  Shape shape;
  shape.type = type;
  shape.size = size;
  return shape;
}

Pose moved(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(x, y, z);
  return pose;
}

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

/// Every pixel against z(slope right, slope down), NaN for nothing. Pixels where `rim` says so are left out.
template <class Depth, class Rim>
void expect_depth(const DepthBuffer& buffer, int label, const Depth& expected, const Rim& rim) {
  const Pinhole& camera = buffer.camera();
  const std::vector<float> depth = buffer.depth();
  int seen = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double right = (u - camera.cx) / camera.fx, down = (v - camera.cy) / camera.fy;
      if (rim(right, down)) continue;
      const std::size_t pixel = static_cast<std::size_t>(v * camera.width + u);
      const double z = expected(right, down);
      ASSERT_EQ(std::isnan(z), std::isnan(depth[pixel])) << "pixel " << u << " " << v << ": " << depth[pixel];
      ASSERT_EQ(buffer.labels()[pixel], std::isnan(z) ? 0 : label) << "pixel " << u << " " << v;
      if (std::isnan(z)) continue;
      ASSERT_NEAR(depth[pixel], z, 1e-6 * z) << "pixel " << u << " " << v;
      ++seen;
    }
  }
  EXPECT_GT(seen, 50);
}

bool no_rim(double, double) {
  return false;
}

/// Depth of the sphere around c along (right, down, 1): along the unit ray e its nearer point is at
/// e . c - sqrt(r^2 - |c|^2 + (e . c)^2).
double sphere_depth(const Vec3& c, double r, double right, double down) {
  const Vec3 e = Vec3(right, down, 1.0).normalized();
  const double along = e.dot(c), root = r * r - c.squaredNorm() + along * along;
  return root < 0.0 ? kNothing : (along - std::sqrt(root)) * e.z();
}

TEST(DepthBuffer, ShowsASphereWhereItIs) {
  DepthBuffer buffer(small_camera());
  const Vec3 c(0.1, -0.07, 0.9);
  buffer.draw_shape(make(Shape::Type::kSphere, {0.2, 0, 0}), moved(c.x(), c.y(), c.z()), 3);
  expect_depth(
      buffer, 3, [&](double right, double down) { return sphere_depth(c, 0.2, right, down); }, no_rim);
}

TEST(DepthBuffer, ShowsAFloorByTheAngleOfSight) {
  // A camera h = 0.8 m above a floor, pitched down by p: a ray a below the axis meets it at range h / sin(p + a) in
  // the vertical plane, depth h cos(a) / sin(p + a); nothing above the horizon.
  const double h = 0.8, pitch = 0.3;
  Pinhole camera = small_camera();
  camera.far = 100.0;
  DepthBuffer buffer(camera);
  Pose floor = Pose::Identity();  // its z axis, up: -y turned about x by the pitch
  floor.linear() = Eigen::AngleAxisd(0.5 * M_PI - pitch, Vec3::UnitX()).toRotationMatrix();
  floor.linear().col(2) = Vec3(0, -std::cos(pitch), -std::sin(pitch));
  floor.linear().col(1) = floor.linear().col(2).cross(Vec3(floor.linear().col(0)));
  floor.translation() = -h * floor.linear().col(2);
  buffer.draw_shape(make(Shape::Type::kPlane, Vec3::Zero()), floor, 65535);
  const auto expected = [&](double, double down) {
    const double a = std::atan(down), z = h * std::cos(a) / std::sin(pitch + a);
    return z > 0.0 && z < camera.far ? z : kNothing;
  };
  expect_depth(buffer, 65535, expected, [&](double r, double d) { return expected(r, d) > 99.9; });
}

TEST(DepthBuffer, ShowsTheFrontOfABoxAndNothingBeside) {
  // Square to the camera its sides are hidden: z is that of the front where |z right - x| and |z down - y| are within.
  DepthBuffer buffer(small_camera());
  buffer.draw_shape(make(Shape::Type::kBox, {0.3, 0.2, 0.5}), moved(0.05, 0.02, 1.25), 7);
  expect_depth(
      buffer, 7,
      [](double right, double down) {
        return std::abs(right - 0.05) <= 0.15 && std::abs(down - 0.02) <= 0.1 ? 1.0 : kNothing;
      },
      no_rim);
}

TEST(DepthBuffer, ShowsATubeAcrossTheImage) {
  // Along x at depth D: in the plane of y and z the ray (down, 1) meets the circle of radius r around (0, D).
  const double r = 0.05, middle = 0.8;
  DepthBuffer buffer(small_camera());
  buffer.draw_tube(Vec3(-5, 0, middle), Vec3(5, 0, middle), r, 2);
  expect_depth(
      buffer, 2,
      [&](double, double down) {
        const double a = 1.0 + down * down, root = middle * middle - a * (middle * middle - r * r);
        return root < 0.0 ? kNothing : (middle - std::sqrt(root)) / a;
      },
      no_rim);
}

TEST(DepthBuffer, ShowsATriangleThatReachesBehindTheCamera) {
  // One that holds the whole floor y = 0.3 from 20 m behind the eye on: z = 0.3 / down from near to far.
  DepthBuffer buffer(small_camera());
  buffer.draw_triangle(Vec3(-500, 0.3, -20), Vec3(500, 0.3, -20), Vec3(0, 0.3, 500), 1);
  expect_depth(
      buffer, 1, [](double, double down) { return down > 0.03 ? 0.3 / down : kNothing; },
      [](double, double down) { return std::abs(down - 0.03) < 1e-9; });
}

TEST(DepthBuffer, LeavesNoGapBetweenTrianglesThatShareAnEdge) {
  // A crooked fan of a rectangle at z = 1: every pixel in it is seen, whichever way its triangles turn.
  DepthBuffer buffer(small_camera());
  const Vec3 corner[] = {{-0.3, -0.2, 1}, {0.31, -0.2, 1}, {0.31, 0.33, 1}, {-0.3, 0.33, 1}};
  const Vec3 middle(0.017, 0.051, 1);
  for (int i = 0; i < 4; ++i) {
    if (i % 2 == 0) {
      buffer.draw_triangle(corner[i], corner[(i + 1) % 4], middle, 1);
    } else {
      buffer.draw_triangle(corner[(i + 1) % 4], corner[i], middle, 1);
    }
  }
  const auto expected = [](double right, double down) {
    return right >= -0.3 && right <= 0.31 && down >= -0.2 && down <= 0.33 ? 1.0 : kNothing;
  };
  expect_depth(buffer, 1, expected, [](double right, double down) {
    return std::min({std::abs(right + 0.3), std::abs(right - 0.31), std::abs(down + 0.2), std::abs(down - 0.33)}) <
           1e-9;
  });
}

TEST(DepthBuffer, ShowsABoxOfTrianglesAndOfVoxelsAsTheBox) {
  // The same solid, oblique, as a box, a mesh and a block of cells. Triangles and slabs differ by roundoff only, which
  // decides at silhouettes: at most a few pixels in a hundred may.
  const Vec3 size(16 * test::kCell, 16 * test::kCell, 16 * test::kCell);
  Pose pose = moved(0.05, 0.03, 0.9);
  pose.linear() = (Eigen::AngleAxisd(0.4, Vec3::UnitX()) * Eigen::AngleAxisd(0.7, Vec3::UnitY())).toRotationMatrix();
  DepthBuffer box(small_camera()), mesh(small_camera()), voxels(small_camera());
  box.draw_shape(make(Shape::Type::kBox, size), pose, 4);

  Shape of_triangles = make(Shape::Type::kMesh, Vec3::Zero());
  TriangleMesh surface = test::box_mesh(size.x(), size.y(), size.z());
  const Vec3 low = surface.rest.rowwise().minCoeff(), high = surface.rest.rowwise().maxCoeff();
  surface.rest.colwise() -= Vec3(0.5 * (low + high));
  of_triangles.mesh = make_collider_meshes(surface)[0];
  mesh.draw_shape(of_triangles, pose, 4);

  Shape of_voxels = make(Shape::Type::kVoxels, Vec3::Zero());
  const test::VoxelGrid grid([](int, int, int) { return true; });
  of_voxels.voxels = std::make_shared<VoxelSolid>(grid.cubes(), test::kCell);
  voxels.draw_shape(of_voxels, pose, 4);

  for (const DepthBuffer* other : {&mesh, &voxels}) {
    const std::vector<float> a = box.depth(), b = other->depth();
    int seen = 0, differ = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      seen += box.labels()[i] == 4 ? 1 : 0;
      if (box.labels()[i] != other->labels()[i]) {
        ++differ;
      } else if (!std::isnan(a[i])) {
        ASSERT_NEAR(a[i], b[i], 1e-6);
      }
    }
    EXPECT_GT(seen, 1000);
    EXPECT_LE(differ, seen / 100);
  }
}

TEST(DepthBuffer, KeepsTheNearestInWhateverOrderItIsDrawn) {
  // A sphere before a plane: the smaller depth of both, and its label.
  const Vec3 c(0, 0, 1.0);
  const Shape sphere = make(Shape::Type::kSphere, {0.2, 0, 0}), plane = make(Shape::Type::kPlane, Vec3::Zero());
  DepthBuffer one(small_camera()), other(small_camera());
  one.draw_shape(sphere, moved(0, 0, 1.0), 1);
  one.draw_shape(plane, moved(0, 0, 0.9), 2);
  other.draw_shape(plane, moved(0, 0, 0.9), 2);
  other.draw_shape(sphere, moved(0, 0, 1.0), 1);
  EXPECT_EQ(one.depth(), other.depth());  // no pixel is empty: no NaN
  EXPECT_EQ(one.labels(), other.labels());
  const Pinhole camera = small_camera();
  const std::vector<float> depth = one.depth();
  int before = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v * camera.width + u);
      const double z = sphere_depth(c, 0.2, (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      const bool sphere_seen = z < 0.9;  // false where it is nothing
      before += sphere_seen ? 1 : 0;
      ASSERT_EQ(one.labels()[pixel], sphere_seen ? 1 : 2);
      ASSERT_NEAR(depth[pixel], sphere_seen ? z : 0.9, 1e-6);
    }
  }
  EXPECT_GT(before, 50);
}

TEST(DepthBuffer, SeesFromNearToFarOnly) {
  // near <= z <= far; what is nearer hides nothing, a sphere that holds the eye is seen from within.
  Pinhole camera = small_camera();
  camera.near = 0.5;
  camera.far = 2.0;
  DepthBuffer buffer(camera);
  const auto wall = [&](double z) {
    buffer.clear();
    buffer.draw_shape(make(Shape::Type::kPlane, Vec3::Zero()), moved(0, 0, z), 1);
    return buffer.depth()[0];
  };
  EXPECT_TRUE(std::isnan(wall(0.499)));
  EXPECT_FLOAT_EQ(wall(0.5), 0.5f);
  EXPECT_FLOAT_EQ(wall(2.0), 2.0f);
  EXPECT_TRUE(std::isnan(wall(2.001)));
  EXPECT_TRUE(std::isnan(wall(-1.0)));
  buffer.clear();
  buffer.draw_shape(make(Shape::Type::kSphere, {1.0, 0, 0}), Pose::Identity(), 1);
  expect_depth(
      buffer, 1, [](double right, double down) { return 1.0 / Vec3(right, down, 1.0).norm(); }, no_rim);
}

TEST(DepthBuffer, StandsWhatHasNoSizeOrIsNotFinite) {
  // Nothing of it is seen, and nothing breaks.
  DepthBuffer buffer(small_camera());
  const double nan = kNothing, inf = std::numeric_limits<double>::infinity();
  buffer.draw_triangle(Vec3(0, 0, 1), Vec3(0, 0, 1), Vec3(0, 0, 1), 1);
  buffer.draw_triangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), 1);
  buffer.draw_triangle(Vec3(nan, 0, 1), Vec3(1, 0, 1), Vec3(0, 1, 1), 1);
  buffer.draw_triangle(Vec3(inf, 0, 1), Vec3(1, 0, 1), Vec3(0, 1, 1), 1);
  buffer.draw_tube(Vec3(0, 0, nan), Vec3(1, 0, 1), 0.1, 1);
  buffer.draw_shape(make(Shape::Type::kPlane, Vec3::Zero()), moved(0, 0, 0), 1);
  EXPECT_EQ(std::count(buffer.labels().begin(), buffer.labels().end(), 0), 120 * 90);
  buffer.draw_tube(Vec3(0, 0, 1), Vec3(0, 0, 1), 0.1, 1);  // a ball
  expect_depth(
      buffer, 1, [](double right, double down) { return sphere_depth(Vec3(0, 0, 1), 0.1, right, down); }, no_rim);
}

}  // namespace
}  // namespace deformable_sim
