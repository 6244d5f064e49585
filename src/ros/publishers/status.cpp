// ~status.
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/publishers/makers.h"

#include <algorithm>
#include <utility>

namespace deformable_sim {

namespace {

class StatusPublisher : public TopicsPublisher {
 public:
  explicit StatusPublisher(const PublisherContext& context) : frame_id_(context.frame_id) {
    topics_.push_back(Topic::advertise<msg::SimStatus>(context, "status"));
  }

  SnapshotDetail detail() const override { return SnapshotDetail::kReports; }

  void publish(const Instant& instant) override {
    const Snapshot& snapshot = instant.snapshot;
    msg::SimStatus message;
    message.header.frame_id = frame_id_;
    message.header.stamp = instant.stamp;
    message.time = snapshot.time;
    message.step = snapshot.dt;
    message.real_time_factor = instant.real_time_factor;
    message.paused = instant.paused;
    message.integrator = snapshot.integrator;
    message.substeps = static_cast<std::uint32_t>(std::max(1, snapshot.substeps));
    message.repeated_steps = snapshot.repeated;
    message.energy_created = snapshot.energy_created;
    message.iterations = static_cast<std::uint32_t>(std::max(0, snapshot.report.newton_iterations));
    message.residual = snapshot.report.residual;
    for (const BodyReport& body : snapshot.bodies) {
      message.kinetic_energy += body.kinetic_energy;
      message.elastic_energy += body.elastic_energy;
      message.potential_energy += body.potential_energy;
      message.max_strain = std::max(message.max_strain, body.max_strain);
    }
    message.max_penetration = snapshot.max_penetration;
    for (const PartCost& cost : snapshot.cost) {
      message.part.push_back(cost.part);
      message.part_cost.push_back(cost.seconds_per_second);
    }
    message.warnings = instant.warnings;
    topics_[0].publish(std::move(message));
  }

 private:
  std::string frame_id_;
};

}  // namespace

std::unique_ptr<Publisher> make_status_publisher(const PublisherContext& context) {
  return std::make_unique<StatusPublisher>(context);
}

}  // namespace deformable_sim
