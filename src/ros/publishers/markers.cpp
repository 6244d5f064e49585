// ~markers.
#include <map>
#include <utility>

#include <visualization_msgs/MarkerArray.h>

#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/contact_drawing.h"
#include "deformable_sim/ros/legend_drawing.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/rigid_drawing.h"
#include "deformable_sim/ros/robot_links.h"
#include "deformable_sim/ros/shadow_drawing.h"

namespace deformable_sim {

namespace {

using visualization_msgs::Marker;

constexpr int kRepeatedDeletes = 30;  // messages: a slow subscriber misses some

class Markers : public TopicsPublisher {
 public:
  explicit Markers(const PublisherContext& context) : frame_id_(context.frame_id), outputs_(context.outputs) {
    topics_.push_back(Topic::advertise<visualization_msgs::MarkerArray>(context, "markers"));
  }

  bool shows_contacts() const override { return outputs_.contact_arrows; }

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

  /// rviz complains about a list without points.
  static void add_list(const std::string& kind, const Body& body, Marker marker,
                       visualization_msgs::MarkerArray* message) {
    if (marker.points.empty()) return;
    marker.ns = kind + "/" + body.name;
    add(std::move(marker), Marker::ADD, message);
  }

  void draw_body(const Snapshot& snapshot, int index, visualization_msgs::MarkerArray* message) const {
    const Body& body = snapshot.model->bodies[static_cast<std::size_t>(index)];
    add_list("body", body, body_marker(snapshot, index, outputs_), message);
    if (outputs_.wireframe) add_list("wireframe", body, wireframe_marker(snapshot, index), message);
    if (outputs_.frames) add_list("frames", body, frames_marker(snapshot, index), message);
    if (outputs_.shadows) add_list("shadow", body, shadow_marker(snapshot, index), message);
    if (!outputs_.contact_arrows) return;
    add_list("contact", body, contact_marker(snapshot, index, contact_arrow_scale(snapshot, outputs_)), message);
  }

  void draw(const Snapshot& snapshot, visualization_msgs::MarkerArray* message) const {
    for (std::size_t i = 0; i < snapshot.model->bodies.size(); ++i) draw_body(snapshot, static_cast<int>(i), message);
    if (outputs_.legend) {
      for (Marker& marker : legend_markers(snapshot, outputs_)) add(std::move(marker), Marker::ADD, message);
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
