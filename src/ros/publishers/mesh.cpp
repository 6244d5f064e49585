// ~<body>/mesh: latched, and still built only when somebody asks.
#include <ros/single_subscriber_publisher.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/shown_body.h"

namespace deformable_sim {

namespace {

msg::BodyMesh mesh_message(const Body& body) {
  msg::BodyMesh message;
  message.body = body.name;
  const TriangleMesh* surface = shown_surface(body);
  const Nodes& rest = surface ? surface->rest : body.line->rest;
  for (int point = 0; point < rest.cols(); ++point) message.mesh.vertices.push_back(to_point(rest.col(point)));
  if (!surface) return message;
  for (const std::array<int, 3>& triangle : surface->triangles) {
    shape_msgs::MeshTriangle indices;
    for (int corner = 0; corner < 3; ++corner) indices.vertex_indices[corner] = triangle[corner];
    message.mesh.triangles.push_back(indices);
  }
  return message;
}

/// Needs no snapshot, so it is never wanted from the simulation: a subscriber's arrival makes the message, which is
/// what latching means to it.
class Meshes : public Publisher {
 public:
  explicit Meshes(const PublisherContext& context) {
    for (const Body& body : context.model->bodies) {
      const auto publish_to = [model = context.model, &body, frame_id = context.frame_id,
                               stamp = context.loaded](const ros::SingleSubscriberPublisher& to) {
        msg::BodyMesh message = mesh_message(body);
        message.header.frame_id = frame_id;
        message.header.stamp = stamp;
        to.publish(message);
      };
      publishers_.push_back(context.advertiser.make([&] {
        ros::NodeHandle nh = context.private_nh;
        return std::make_unique<ros::Publisher>(
            nh.advertise<msg::BodyMesh>(body.name + "/mesh", 1, publish_to, {}, {}, true));
      }));
    }
  }

  bool wanted() const override { return false; }
  unsigned joined() const override { return 0; }
  void publish(const Instant&) override {}

 private:
  std::vector<std::shared_ptr<ros::Publisher>> publishers_;
};

}  // namespace

std::unique_ptr<Publisher> make_mesh_publisher(const PublisherContext& context) {
  return std::make_unique<Meshes>(context);
}

}  // namespace deformable_sim
