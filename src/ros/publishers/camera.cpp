// ~camera/<camera>/depth, camera_info, points, segmentation and labels.
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <ros/console.h>

#include "deformable_sim/ros/camera/camera_messages.h"
#include "deformable_sim/ros/camera/camera_view.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/warnings.h"

namespace deformable_sim {

namespace {

/// An image takes longer than all other messages together, so each camera draws on a thread of its own, begun with its
/// first subscriber: the newest state when it is ready, as Outputs does.
class Camera : public TopicsPublisher {
 public:
  Camera(const PublisherContext& context, CameraParameters camera, std::shared_ptr<SegmentIds> ids)
      : camera_(std::move(camera)),
        world_frame_(context.frame_id),
        frames_(context.frames),
        warnings_(context.warnings),
        ids_(std::move(ids)) {
    const std::string prefix = "camera/" + camera_.name + "/";
    topics_.resize(kTopics);
    topics_[kDepth] = Topic::advertise<sensor_msgs::Image>(context, prefix + "depth");
    topics_[kInfo] = Topic::advertise<sensor_msgs::CameraInfo>(context, prefix + "camera_info");
    topics_[kPoints] = Topic::advertise<sensor_msgs::PointCloud2>(context, prefix + "points");
    topics_[kSegmentation] = Topic::advertise<sensor_msgs::Image>(context, prefix + "segmentation");
    topics_[kLabels] = Topic::advertise<msg::SegmentLabels>(context, prefix + "labels");
  }

  ~Camera() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    arrived_.notify_one();
    if (thread_.joinable()) thread_.join();
    frame_is_known();
  }

  bool wanted() const override {
    const bool wanted = TopicsPublisher::wanted();
    if (!wanted) frame_is_known();  // or of no interest
    return wanted;
  }

  void publish(const Instant& instant) override {
    const std::optional<Pose> world_from_camera = pose();
    if (!world_from_camera) return;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      shot_ = std::make_unique<Shot>(Shot{instant, *world_from_camera});
      if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    }
    arrived_.notify_one();
  }

 private:
  enum TopicIndex { kDepth, kInfo, kPoints, kSegmentation, kLabels, kTopics };

  struct Shot {
    Instant instant;
    Pose world_from_camera;
  };

  std::string warning_key() const { return "camera " + camera_.name; }

  void frame_is_known() const {
    if (frame_is_missing_.exchange(false)) warnings_->clear(warning_key());
  }

  /// Nothing, and a warning, while the frame is not known.
  std::optional<Pose> pose() {
    std::optional<Pose> pose;
    if (camera_.frame == world_frame_) {
      pose = Pose::Identity();
    } else if (const auto found = frames_->latest(camera_.frame)) {
      pose = found->world_from_frame;
    }
    if (pose) {
      frame_is_known();
      return pose;
    }
    const std::string text = "camera " + camera_.name + " sees nothing: no transform yet from tf frame '" +
                             printable(camera_.frame) + "' to '" + world_frame_ + "'";
    warnings_->set(warning_key(), text);  // again: the camera of a scene that was replaced clears the same key
    if (!frame_is_missing_.exchange(true)) ROS_WARN_STREAM_NAMED("camera", text);
    return pose;
  }

  void run() {
    DepthBuffer buffer(camera_.pinhole);
    while (true) {
      std::unique_ptr<Shot> shot;
      {
        std::unique_lock<std::mutex> lock(mutex_);
        arrived_.wait(lock, [this] { return stopping_ || shot_; });
        if (stopping_) return;
        shot = std::move(shot_);
      }
      show(*shot, &buffer);
    }
  }

  template <class Message>
  void send(TopicIndex topic, Message message, const Instant& instant) const {
    message.header.frame_id = camera_.frame;
    message.header.stamp = instant.stamp;
    topics_[topic].publish(std::move(message));
  }

  void show(const Shot& shot, DepthBuffer* buffer) const {
    const Snapshot& snapshot = shot.instant.snapshot;
    const SegmentIds::OfSnapshot ids = ids_->of(snapshot);
    if (topics_[kInfo].wanted()) send(kInfo, camera_info(camera_.pinhole), shot.instant);
    if (topics_[kLabels].wanted()) send(kLabels, segment_labels(snapshot, ids), shot.instant);
    const bool depth_wanted = topics_[kDepth].wanted(), points_wanted = topics_[kPoints].wanted();
    if (!depth_wanted && !points_wanted && !topics_[kSegmentation].wanted()) return;
    buffer->clear();
    draw_world(snapshot, ids, shot.world_from_camera, buffer);
    if (topics_[kSegmentation].wanted()) {
      send(kSegmentation, segmentation_image(camera_.pinhole, buffer->labels()), shot.instant);
    }
    if (!depth_wanted && !points_wanted) return;
    std::vector<float> depth = buffer->depth();
    if (camera_.noise.any()) add_noise(camera_.pinhole, camera_.noise, snapshot.step, &depth);
    if (depth_wanted) send(kDepth, depth_image(camera_.pinhole, depth), shot.instant);
    if (points_wanted) send(kPoints, camera_cloud(camera_.pinhole, depth, buffer->labels()), shot.instant);
  }

  const CameraParameters camera_;
  const std::string world_frame_;
  const Frames* const frames_;
  Warnings* const warnings_;
  const std::shared_ptr<SegmentIds> ids_;
  mutable std::atomic<bool> frame_is_missing_{false};

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::unique_ptr<Shot> shot_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Publisher> make_camera_publisher(const PublisherContext& context, const CameraParameters& camera,
                                                 const std::shared_ptr<SegmentIds>& ids) {
  return std::make_unique<Camera>(context, camera, ids);
}

}  // namespace deformable_sim
