#include "deformable_sim/ros/camera/camera_messages.h"

#include <cstring>

#include <sensor_msgs/distortion_models.h>
#include <sensor_msgs/image_encodings.h>

namespace deformable_sim {

namespace {

template <class Value>
sensor_msgs::Image image(const Pinhole& camera, const char* encoding, const std::vector<Value>& values) {
  sensor_msgs::Image message;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.encoding = encoding;
  message.is_bigendian = 0;
  message.step = message.width * sizeof(Value);
  message.data.resize(values.size() * sizeof(Value));
  std::memcpy(message.data.data(), values.data(), message.data.size());
  return message;
}

}  // namespace

sensor_msgs::CameraInfo camera_info(const Pinhole& camera) {
  sensor_msgs::CameraInfo info;
  info.width = static_cast<std::uint32_t>(camera.width);
  info.height = static_cast<std::uint32_t>(camera.height);
  info.distortion_model = sensor_msgs::distortion_models::PLUMB_BOB;
  info.D.assign(5, 0.0);
  info.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  return info;
}

sensor_msgs::Image depth_image(const Pinhole& camera, const std::vector<float>& depth) {
  return image(camera, sensor_msgs::image_encodings::TYPE_32FC1.c_str(), depth);
}

sensor_msgs::Image segmentation_image(const Pinhole& camera, const std::vector<std::uint16_t>& labels) {
  return image(camera, sensor_msgs::image_encodings::TYPE_16UC1.c_str(), labels);
}

sensor_msgs::PointCloud2 camera_cloud(const Pinhole& camera, const std::vector<float>& depth,
                                      const std::vector<std::uint16_t>& labels) {
  sensor_msgs::PointCloud2 cloud;
  for (const char* name : {"x", "y", "z", "label"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = cloud.point_step;
    field.datatype =
        std::strcmp(name, "label") == 0 ? sensor_msgs::PointField::UINT32 : sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud.fields.push_back(field);
    cloud.point_step += 4;
  }
  cloud.width = static_cast<std::uint32_t>(camera.width);
  cloud.height = static_cast<std::uint32_t>(camera.height);
  cloud.row_step = cloud.width * cloud.point_step;
  cloud.is_dense = false;
  cloud.data.resize(static_cast<std::size_t>(cloud.height) * cloud.row_step);
  std::uint8_t* out = cloud.data.data();
  std::size_t pixel = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++pixel, out += cloud.point_step) {
      const Eigen::Vector3f point = (static_cast<double>(depth[pixel]) * camera.ray(u, v)).cast<float>();
      const std::uint32_t label = labels[pixel];
      std::memcpy(out, point.data(), 12);
      std::memcpy(out + 12, &label, 4);
    }
  }
  return cloud;
}

msg::SegmentLabels segment_labels(const Snapshot& snapshot, const SegmentIds::OfSnapshot& ids) {
  msg::SegmentLabels message;
  for (std::size_t i = 0; i < ids.bodies.size(); ++i) {
    message.label.push_back(ids.bodies[i]);
    message.name.push_back(snapshot.model->bodies[i].name);
  }
  for (std::size_t i = 0; i < ids.colliders.size(); ++i) {
    message.label.push_back(ids.colliders[i]);
    message.name.push_back(snapshot.colliders[i].name);
  }
  return message;
}

}  // namespace deformable_sim
