// Constructors of all outputs, one file each in src/ros/publishers.
#pragma once

#include <memory>

#include "deformable_sim/ros/camera/camera_parameters.h"
#include "deformable_sim/ros/camera/segment_ids.h"
#include "deformable_sim/ros/publishers/publisher.h"

namespace deformable_sim {

/// ~markers, visualization_msgs/MarkerArray: bodies, colliders and grasps for rviz.
std::unique_ptr<Publisher> make_markers_publisher(const PublisherContext& context);
/// ~<body>/points, sensor_msgs/PointCloud2 of 44 B a node.
std::unique_ptr<Publisher> make_body_points_publisher(const PublisherContext& context);
/// ~points, sensor_msgs/PointCloud2 of all bodies, 48 B a node.
std::unique_ptr<Publisher> make_all_points_publisher(const PublisherContext& context);
/// ~<body>/state, BodyState.
std::unique_ptr<Publisher> make_body_state_publisher(const PublisherContext& context);
/// ~<body>/mesh, BodyMesh, latched, built when first asked for.
std::unique_ptr<Publisher> make_mesh_publisher(const PublisherContext& context);
/// ~grasps, GraspStateArray.
std::unique_ptr<Publisher> make_grasps_publisher(const PublisherContext& context);
/// ~grasp/<name>/wrench, geometry_msgs/WrenchStamped in the grasp frame.
std::unique_ptr<Publisher> make_wrench_publisher(const PublisherContext& context);
/// ~contacts, ContactArray.
std::unique_ptr<Publisher> make_contacts_publisher(const PublisherContext& context);
/// ~contact/<collider>/wrench, geometry_msgs/WrenchStamped in the tf frame the collider is attached to.
std::unique_ptr<Publisher> make_contact_wrench_publisher(const PublisherContext& context);
/// ~status, SimStatus.
std::unique_ptr<Publisher> make_status_publisher(const PublisherContext& context);
/// /diagnostics, REP 107.
std::unique_ptr<Publisher> make_diagnostics_publisher(const PublisherContext& context);
/// /tf: one frame a body and a grasp.
std::unique_ptr<Publisher> make_transforms_publisher(const PublisherContext& context);
/// ~interactive_markers, interactive markers: a person drags a grasp.
std::unique_ptr<Publisher> make_handles_publisher(const PublisherContext& context);
/// ~camera/<camera>/...: depth image, cloud and segmentation of one camera, at its own rate.
std::unique_ptr<Publisher> make_camera_publisher(const PublisherContext& context, const CameraParameters& camera,
                                                 const std::shared_ptr<SegmentIds>& ids);

}  // namespace deformable_sim
