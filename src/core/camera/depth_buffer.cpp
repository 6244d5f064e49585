#include "deformable_sim/core/camera/depth_buffer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/camera/shape_rays.h"
#include "deformable_sim/core/contact/collider_mesh.h"
#include "deformable_sim/core/contact/voxel_solid.h"

namespace deformable_sim {

namespace {

/// A function of the ray that is linear in the pixel: at(u, v) = n . ray(u, v).
struct PixelLinear {
  double along_u, along_v, start;

  PixelLinear(const Pinhole& camera, const Vec3& n)
      : along_u(n.x() / camera.fx),
        along_v(n.y() / camera.fy),
        start(n.z() - along_u * camera.cx - along_v * camera.cy) {}

  double row(int v) const { return start + along_v * v; }
};

}  // namespace

DepthBuffer::DepthBuffer(const Pinhole& camera)
    : camera_(camera),
      nearest_(1.0 / camera.near),
      farthest_(1.0 / camera.far),
      inverse_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)),
      labels_(inverse_.size()) {
  clear();
}

void DepthBuffer::clear() {
  std::fill(inverse_.begin(), inverse_.end(), std::nextafter(farthest_, 0.0));
  std::fill(labels_.begin(), labels_.end(), std::uint16_t{0});
}

void DepthBuffer::draw_triangle(const Vec3& a, const Vec3& b, const Vec3& c, std::uint16_t label) {
  const Vec3 corners[3] = {a, b, c};
  const PixelBox box = pixels_of_hull(camera_, corners, 3);
  if (box.empty()) return;
  const Vec3 ab = a.cross(b), bc = b.cross(c), ca = c.cross(a);
  const double volume = ab.dot(c);  // six times that of the tetrahedron with the eye
  if (volume == 0.0) return;        // seen from its edge
  const double side = std::copysign(1.0, volume), scale = 1.0 / std::abs(volume);
  const PixelLinear on_ab(camera_, side * ab), on_bc(camera_, side * bc), on_ca(camera_, side * ca);
  for (int v = box.first_v; v <= box.last_v; ++v) {
    const double row_ab = on_ab.row(v), row_bc = on_bc.row(v), row_ca = on_ca.row(v);
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width);
    for (int u = box.first_u; u <= box.last_u; ++u) {
      const double e0 = row_ab + on_ab.along_u * u, e1 = row_bc + on_bc.along_u * u, e2 = row_ca + on_ca.along_u * u;
      if (e0 < 0.0 || e1 < 0.0 || e2 < 0.0) continue;
      put(row + static_cast<std::size_t>(u), scale * (e0 + e1 + e2), label);
    }
  }
}

void DepthBuffer::draw_triangles(const Nodes& x, const std::vector<std::array<int, 3>>& triangles,
                                 std::uint16_t label) {
  for (const std::array<int, 3>& t : triangles) draw_triangle(x.col(t[0]), x.col(t[1]), x.col(t[2]), label);
}

void DepthBuffer::draw_shape(const Shape& shape, const Pose& camera_from_shape, std::uint16_t label) {
  switch (shape.type) {
    case Shape::Type::kPlane:
      return draw_plane(camera_from_shape, label);
    case Shape::Type::kMesh: {
      const std::vector<Vec3>& vertices = shape.mesh->vertices();
      Nodes x(3, static_cast<Eigen::Index>(vertices.size()));
      for (std::size_t i = 0; i < vertices.size(); ++i)
        x.col(static_cast<Eigen::Index>(i)) = camera_from_shape * vertices[i];
      return draw_triangles(x, shape.mesh->triangles(), label);
    }
    case Shape::Type::kVoxels:
      return draw_voxels(*shape.voxels, camera_from_shape, label);
    default:
      return draw_convex(shape, camera_from_shape, label);
  }
}

void DepthBuffer::draw_tube(const Vec3& a, const Vec3& b, double radius, std::uint16_t label) {
  Shape capsule;
  capsule.type = Shape::Type::kCapsule;
  capsule.size = Vec3(radius, (b - a).norm(), 0.0);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), b - a).toRotationMatrix();
  pose.translation() = 0.5 * (a + b);
  draw_convex(capsule, pose, label);
}

/// Points p with n . p = n . p0, n the plane's z axis: 1/z = n . d / n . p0.
void DepthBuffer::draw_plane(const Pose& camera_from_plane, std::uint16_t label) {
  const Vec3 normal = camera_from_plane.linear().col(2);
  const double distance = normal.dot(camera_from_plane.translation());
  if (distance == 0.0) return;  // seen from its edge
  const PixelLinear inverse(camera_, normal / distance);
  std::size_t pixel = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) put(pixel++, inverse.row(v) + inverse.along_u * u, label);
  }
}

void DepthBuffer::draw_convex(const Shape& shape, const Pose& camera_from_shape, std::uint16_t label) {
  const Vec3 half = half_extents(shape);
  Vec3 corners[8];
  for (int i = 0; i < 8; ++i) {
    const Vec3 signs((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
    corners[i] = camera_from_shape * half.cwiseProduct(signs);
  }
  const PixelBox box = pixels_of_hull(camera_, corners, 8);
  const Pose shape_from_camera = camera_from_shape.inverse(Eigen::Isometry);
  const Vec3 origin = shape_from_camera.translation();
  const Mat3 turn = shape_from_camera.linear();
  for (int v = box.first_v; v <= box.last_v; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width);
    for (int u = box.first_u; u <= box.last_u; ++u) {
      const RayInterval within = inside(shape, origin, turn * camera_.ray(u, v));
      if (within.empty()) continue;
      // The front is before the near plane: what is seen is the back, from within.
      const double z = within.enter >= camera_.near ? within.enter : within.leave;
      if (z > 0.0) put(row + static_cast<std::size_t>(u), 1.0 / z, label);
    }
  }
}

void DepthBuffer::draw_voxels(const VoxelSolid& voxels, const Pose& camera_from_voxels, std::uint16_t label) {
  for (const VoxelSquare& square : voxels.squares()) {
    Vec3 corner[4];
    for (int k = 0; k < 4; ++k) {
      Vec3 at(square.corner[0], square.corner[1], square.corner[2]);
      if (k == 1 || k == 2) at[(square.axis + 1) % 3] += square.size;
      if (k >= 2) at[(square.axis + 2) % 3] += square.size;
      corner[k] = camera_from_voxels * (voxels.resolution() * at);
    }
    draw_triangle(corner[0], corner[1], corner[2], label);
    draw_triangle(corner[0], corner[2], corner[3], label);
  }
}

std::vector<float> DepthBuffer::depth() const {
  std::vector<float> z(inverse_.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    z[i] = labels_[i] == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(1.0 / inverse_[i]);
  }
  return z;
}

}  // namespace deformable_sim
