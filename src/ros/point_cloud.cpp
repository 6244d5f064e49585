#include "deformable_sim/ros/point_cloud.h"

#include <cstdint>
#include <cstring>

#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

constexpr int kFloats = 10;  // position, normal, velocity, strain

sensor_msgs::PointCloud2 empty_cloud(bool with_body) {
  sensor_msgs::PointCloud2 cloud;
  std::uint32_t offset = 0;
  const auto add = [&](const char* name, std::uint8_t type) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = type;
    field.count = 1;
    cloud.fields.push_back(field);
    offset += 4;
  };
  for (const char* name : {"x", "y", "z", "normal_x", "normal_y", "normal_z", "vx", "vy", "vz", "strain"}) {
    add(name, sensor_msgs::PointField::FLOAT32);
  }
  add("node", sensor_msgs::PointField::UINT32);
  if (with_body) add("body", sensor_msgs::PointField::UINT32);
  cloud.point_step = offset;
  cloud.is_dense = true;
  return cloud;
}

void size(std::uint32_t height, std::uint32_t width, sensor_msgs::PointCloud2* cloud) {
  cloud->height = height;
  cloud->width = width;
  cloud->row_step = width * cloud->point_step;
  cloud->data.resize(static_cast<std::size_t>(height) * cloud->row_step);
}

/// Writes the points of one body; returns where the next one begins.
std::uint8_t* write(const Snapshot& snapshot, std::uint32_t body_index, std::uint32_t step, std::uint8_t* out) {
  const Body& body = snapshot.model->bodies[body_index];
  const ShownColumns x = shown_positions(snapshot, body), v = shown_velocities(snapshot, body);
  const Eigen::Matrix3Xf normals = shown_normals(snapshot, body, x);
  const Eigen::VectorXf strain = shown_values(body, node_strain(body, snapshot.x));
  for (int point = 0; point < x.cols(); ++point, out += step) {
    Eigen::Matrix<float, kFloats, 1> values;
    values << x.col(point).cast<float>(), normals.col(point), v.col(point).cast<float>(), strain[point];
    const std::uint32_t tail[2] = {static_cast<std::uint32_t>(shown_node(body, point)), body_index};
    std::memcpy(out, values.data(), 4 * kFloats);
    std::memcpy(out + 4 * kFloats, tail, step - 4 * kFloats);
  }
  return out;
}

}  // namespace

sensor_msgs::PointCloud2 body_cloud(const Snapshot& snapshot, int body) {
  const Body& shape = snapshot.model->bodies[body];
  sensor_msgs::PointCloud2 cloud = empty_cloud(false);
  const TriangleMesh* surface = shown_surface(shape);
  const bool grid = surface && surface->is_grid();
  size(grid ? surface->rows : 1, grid ? surface->cols : shown_count(shape), &cloud);
  write(snapshot, body, cloud.point_step, cloud.data.data());
  return cloud;
}

sensor_msgs::PointCloud2 world_cloud(const Snapshot& snapshot) {
  sensor_msgs::PointCloud2 cloud = empty_cloud(true);
  int points = 0;
  for (const Body& body : snapshot.model->bodies) points += shown_count(body);
  size(1, points, &cloud);
  std::uint8_t* out = cloud.data.data();
  for (std::size_t body = 0; body < snapshot.model->bodies.size(); ++body) {
    out = write(snapshot, static_cast<std::uint32_t>(body), cloud.point_step, out);
  }
  return cloud;
}

}  // namespace deformable_sim
