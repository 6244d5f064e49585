// ~<body>/points and ~points.
#include "deformable_sim/ros/point_cloud.h"
#include "deformable_sim/ros/publishers/makers.h"

namespace deformable_sim {

namespace {

class BodyPoints : public TopicsPublisher {
 public:
  explicit BodyPoints(const PublisherContext& context) : frame_id_(context.frame_id) {
    for (const Body& body : context.model->bodies) {
      topics_.push_back(Topic::advertise<sensor_msgs::PointCloud2>(context, body.name + "/points"));
    }
  }

  void publish(const Instant& instant) override {
    for (std::size_t body = 0; body < topics_.size(); ++body) {
      if (!topics_[body].wanted()) continue;
      sensor_msgs::PointCloud2 cloud = body_cloud(instant.snapshot, static_cast<int>(body));
      cloud.header.frame_id = frame_id_;
      cloud.header.stamp = instant.stamp;
      topics_[body].publish(std::move(cloud));
    }
  }

 private:
  std::string frame_id_;
};

class AllPoints : public TopicsPublisher {
 public:
  explicit AllPoints(const PublisherContext& context) : frame_id_(context.frame_id) {
    topics_.push_back(Topic::advertise<sensor_msgs::PointCloud2>(context, "points"));
  }

  void publish(const Instant& instant) override {
    sensor_msgs::PointCloud2 cloud = world_cloud(instant.snapshot);
    cloud.header.frame_id = frame_id_;
    cloud.header.stamp = instant.stamp;
    topics_[0].publish(std::move(cloud));
  }

 private:
  std::string frame_id_;
};

}  // namespace

std::unique_ptr<Publisher> make_body_points_publisher(const PublisherContext& context) {
  return std::make_unique<BodyPoints>(context);
}

std::unique_ptr<Publisher> make_all_points_publisher(const PublisherContext& context) {
  return std::make_unique<AllPoints>(context);
}

}  // namespace deformable_sim
