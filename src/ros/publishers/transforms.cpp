// /tf: <node>/<body> at the centre of mass, <node>/grasp/<name> at the grasp.
#include <tf2_msgs/TFMessage.h>
#include <utility>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/publishers/makers.h"

namespace deformable_sim {

namespace {

class Transforms : public TopicsPublisher {
 public:
  explicit Transforms(const PublisherContext& context) : frame_id_(context.frame_id), prefix_(context.node_name + "/") {
    topics_.push_back(Topic::advertise<tf2_msgs::TFMessage>(context, "/tf"));
  }

  void publish(const Instant& instant) override {
    if (instant.stamp == last_) return;  // tf complains about a stamp that comes twice
    last_ = instant.stamp;
    const Snapshot& snapshot = instant.snapshot;
    tf2_msgs::TFMessage message;
    for (const Body& body : snapshot.model->bodies) {
      const auto mass = snapshot.model->mass.segment(body.first_node, body.node_count);
      Pose pose = Pose::Identity();
      pose.translation() = snapshot.x.middleCols(body.first_node, body.node_count) * mass / mass.sum();
      message.transforms.push_back(transform(body.name, pose, instant.stamp));
    }
    for (const GraspReport& grasp : snapshot.grasps) {
      message.transforms.push_back(transform("grasp/" + grasp.name, grasp.world_from_grasp, instant.stamp));
    }
    topics_[0].publish(std::move(message));
  }

 private:
  geometry_msgs::TransformStamped transform(const std::string& child, const Pose& pose, ros::Time stamp) const {
    geometry_msgs::TransformStamped message;
    message.header.frame_id = frame_id_;
    message.header.stamp = stamp;
    message.child_frame_id = prefix_ + child;
    message.transform.translation = to_vector(pose.translation());
    message.transform.rotation = to_message(pose).orientation;
    return message;
  }

  std::string frame_id_;
  std::string prefix_;
  ros::Time last_;
};

}  // namespace

std::unique_ptr<Publisher> make_transforms_publisher(const PublisherContext& context) {
  return std::make_unique<Transforms>(context);
}

}  // namespace deformable_sim
