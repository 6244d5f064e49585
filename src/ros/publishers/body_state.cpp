// ~<body>/state.
#include "deformable_sim/ros/publishers/makers.h"
#include "deformable_sim/ros/state_messages.h"

namespace deformable_sim {

namespace {

class BodyStates : public TopicsPublisher {
 public:
  explicit BodyStates(const PublisherContext& context) : frame_id_(context.frame_id) {
    for (const Body& body : context.model->bodies) {
      topics_.push_back(Topic::advertise<msg::BodyState>(context, body.name + "/state"));
    }
  }

  SnapshotDetail detail() const override { return SnapshotDetail::kReports; }

  void publish(const Instant& instant) override {
    for (std::size_t body = 0; body < topics_.size(); ++body) {
      if (!topics_[body].wanted()) continue;
      topics_[body].publish(body_state_message(instant.snapshot, static_cast<int>(body), frame_id_, instant.stamp));
    }
  }

 private:
  std::string frame_id_;
};

}  // namespace

std::unique_ptr<Publisher> make_body_state_publisher(const PublisherContext& context) {
  return std::make_unique<BodyStates>(context);
}

}  // namespace deformable_sim
