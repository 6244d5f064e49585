// What a depth camera publishes, without headers.
#pragma once

#include <cstdint>
#include <vector>

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>

#include "deformable_sim/core/camera/pinhole.h"
#include "deformable_sim/ros/camera/segment_ids.h"
#include "deformable_sim/ros/messages.h"

namespace deformable_sim {

/// Without distortion (plumb_bob of zeros), rectified: P = [K 0].
sensor_msgs::CameraInfo camera_info(const Pinhole& camera);
/// 32FC1: z in the optical frame (m), NaN where nothing is seen [REP 118].
sensor_msgs::Image depth_image(const Pinhole& camera, const std::vector<float>& depth);
/// 16UC1.
sensor_msgs::Image segmentation_image(const Pinhole& camera, const std::vector<std::uint16_t>& labels);
/// Organised as the image, 16 B a point: x y z (float32, m, NaN where nothing is seen), label (uint32).
sensor_msgs::PointCloud2 camera_cloud(const Pinhole& camera, const std::vector<float>& depth,
                                      const std::vector<std::uint16_t>& labels);
msg::SegmentLabels segment_labels(const Snapshot& snapshot, const SegmentIds::OfSnapshot& ids);

}  // namespace deformable_sim
