// ~markers.
#include <map>
#include <utility>

#include <visualization_msgs/MarkerArray.h>

#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/rigid_drawing.h"
#include "deformable_sim/ros/robot_links.h"

namespace deformable_sim {

namespace {

using visualization_msgs::Marker;

constexpr int kRepeatedDeletes = 30;  // messages: a slow subscriber misses some

class Markers : public TopicsPublisher {
 public:
  explicit Markers(const PublisherContext& context) : frame_id_(context.frame_id), outputs_(context.outputs) {
    topics_.push_back(Topic::advertise<visualization_msgs::MarkerArray>(context, "markers"));
  }

  void publish(const Instant& instant) override {
    visualization_msgs::MarkerArray message;
    // What an earlier scene has left on the screen.
    if (first_) add(blank_marker(), Marker::DELETEALL, &message);
    first_ = false;
    draw(instant.snapshot, &message);
    delete_absent(&message);
    for (Marker& marker : message.markers) {
      marker.header.frame_id = frame_id_;
      marker.header.stamp = instant.stamp;
    }
    topics_[0].publish(std::move(message));
  }

 private:
  using Key = std::pair<std::string, int>;

  static void add(Marker marker, int action, visualization_msgs::MarkerArray* message) {
    marker.action = action;
    message->markers.push_back(std::move(marker));
  }

  void draw(const Snapshot& snapshot, visualization_msgs::MarkerArray* message) const {
    for (std::size_t i = 0; i < snapshot.model->bodies.size(); ++i) {
      Marker marker = body_marker(snapshot, static_cast<int>(i), outputs_);
      marker.ns = "body/" + snapshot.model->bodies[i].name;
      if (!marker.points.empty()) add(std::move(marker), Marker::ADD, message);
      if (outputs_.wireframe) {
        Marker lines = wireframe_marker(snapshot, static_cast<int>(i));
        lines.ns = "wireframe/" + snapshot.model->bodies[i].name;
        add(std::move(lines), Marker::ADD, message);
      }
      if (outputs_.frames && snapshot.model->bodies[i].first_segment >= 0) {
        Marker frames = frames_marker(snapshot, static_cast<int>(i));
        frames.ns = "frames/" + snapshot.model->bodies[i].name;
        add(std::move(frames), Marker::ADD, message);
      }
    }
    for (const Collider& collider : snapshot.colliders) {
      if (collider.name.rfind(kRobotPrefix, 0) == 0) continue;  // rviz draws the robot itself
      for (Marker& marker : collider_markers(collider)) add(std::move(marker), Marker::ADD, message);
    }
    for (const GraspReport& grasp : snapshot.grasps) {
      for (Marker& marker : grasp_markers(grasp)) add(std::move(marker), Marker::ADD, message);
    }
  }

  void delete_absent(visualization_msgs::MarkerArray* message) {
    for (auto& [key, remaining] : shown_) --remaining;
    for (const Marker& marker : message->markers) {
      if (marker.action == Marker::ADD) shown_[{marker.ns, marker.id}] = kRepeatedDeletes;
    }
    for (auto it = shown_.begin(); it != shown_.end();) {
      if (it->second < kRepeatedDeletes) {
        Marker marker = blank_marker();
        marker.ns = it->first.first;
        marker.id = it->first.second;
        add(marker, Marker::DELETE, message);
      }
      it = it->second <= 0 ? shown_.erase(it) : std::next(it);
    }
  }

  std::string frame_id_;
  OutputSpec outputs_;
  bool first_ = true;
  std::map<Key, int> shown_;  // how often a DELETE is still repeated once it is gone
};

}  // namespace

std::unique_ptr<Publisher> make_markers_publisher(const PublisherContext& context) {
  return std::make_unique<Markers>(context);
}

}  // namespace deformable_sim
