// ~interactive_markers: a 6-dof interactive marker for each grasp that no tf frame moves.
#include <map>
#include <mutex>

#include <interactive_markers/interactive_marker_server.h>
#include <visualization_msgs/InteractiveMarker.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/publishers/makers.h"

namespace deformable_sim {

namespace {

constexpr double kHandleSize = 0.15;  // m
constexpr double kMoved = 1e-5;       // m, and radians: smaller motion is not worth a message

/// Turning about and moving along one axis of the grasp frame.
void add_axis(const char* name, double x, double y, double z, visualization_msgs::InteractiveMarker* marker) {
  visualization_msgs::InteractiveMarkerControl control;
  const double norm = std::sqrt(1.0 + x * x + y * y + z * z);
  control.orientation.w = 1.0 / norm;
  control.orientation.x = x / norm;
  control.orientation.y = y / norm;
  control.orientation.z = z / norm;
  control.name = std::string("move_") + name;
  control.interaction_mode = visualization_msgs::InteractiveMarkerControl::MOVE_AXIS;
  marker->controls.push_back(control);
  control.name = std::string("turn_") + name;
  control.interaction_mode = visualization_msgs::InteractiveMarkerControl::ROTATE_AXIS;
  marker->controls.push_back(control);
}

bool moved(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm() > kMoved || (a.linear() - b.linear()).norm() > kMoved;
}

bool is_pose(const geometry_msgs::Pose& pose) {
  try {
    to_pose(pose, "the handle");
    return true;
  } catch (const InputError&) {
    return false;
  }
}

class Handles : public TopicsPublisher {
 public:
  explicit Handles(const PublisherContext& context)
      : advertiser_(context.advertiser),
        topic_(context.private_nh.resolveName("interactive_markers")),
        frame_id_(context.frame_id),
        drag_(context.drag_grasp) {
    // The server's own topic: shared, so that the server can wait until somebody listens.
    topics_.push_back(
        Topic::advertise<visualization_msgs::InteractiveMarkerUpdate>(context, "interactive_markers/update"));
  }

  void publish(const Instant& instant) override {
    if (!server_) {
      // On a thread of its own: on the node's, its timer would publish with what its destructor has let go.
      server_ = advertiser_.make(
          [this] { return std::make_unique<interactive_markers::InteractiveMarkerServer>(topic_, "", true); });
    }
    std::map<std::string, Pose> present;
    for (const GraspReport& grasp : instant.snapshot.grasps) {
      if (!grasp.follow_frame.empty() || grasp.phase == GraspPhase::kSlipped) continue;
      present[grasp.name] = grasp.world_from_grasp;
    }
    for (const auto& [name, pose] : shown_) {
      if (present.count(name) == 0) server_->erase(name);
    }
    for (auto& [name, pose] : present) {
      const auto known = shown_.find(name);
      if (known == shown_.end()) {
        insert(name, pose);
      } else if (moved(pose, known->second)) {
        server_->setPose(name, to_message(pose));
      } else {
        pose = known->second;
      }
    }
    {
      const std::lock_guard<std::mutex> lock(shown_mutex_);
      shown_.swap(present);
    }
    server_->applyChanges();
  }

 private:
  void insert(const std::string& name, const Pose& pose) {
    visualization_msgs::InteractiveMarker marker;
    marker.header.frame_id = frame_id_;
    marker.name = name;
    marker.description = name;
    marker.scale = kHandleSize;
    marker.pose = to_message(pose);
    add_axis("x", 1, 0, 0, &marker);
    add_axis("y", 0, 0, 1, &marker);
    add_axis("z", 0, 1, 0, &marker);
    server_->insert(marker, [this](const visualization_msgs::InteractiveMarkerFeedbackConstPtr& feedback) {
      if (feedback->event_type != visualization_msgs::InteractiveMarkerFeedback::POSE_UPDATE) return;
      // The server, which holds its lock here, has taken the pose as it came, and would show it.
      if (!is_pose(feedback->pose)) put_back(feedback->marker_name);
      geometry_msgs::PoseStamped target;
      target.header = feedback->header;
      target.pose = feedback->pose;
      drag_(feedback->marker_name, target);
    });
  }

  void put_back(const std::string& name) {
    const std::lock_guard<std::mutex> lock(shown_mutex_);
    const auto known = shown_.find(name);
    server_->setPose(name, to_message(known == shown_.end() ? Pose::Identity() : known->second));
  }

  Advertiser advertiser_;
  std::string topic_;
  std::string frame_id_;
  std::function<void(const std::string&, const geometry_msgs::PoseStamped&)> drag_;
  std::mutex shown_mutex_;             // held where shown_ changes, and where the server's thread reads it
  std::map<std::string, Pose> shown_;  // changed by publish() alone
  std::shared_ptr<interactive_markers::InteractiveMarkerServer> server_;
};

}  // namespace

std::unique_ptr<Publisher> make_handles_publisher(const PublisherContext& context) {
  return std::make_unique<Handles>(context);
}

}  // namespace deformable_sim
