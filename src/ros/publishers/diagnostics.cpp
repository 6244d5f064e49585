// /diagnostics (REP 107).
#include <diagnostic_msgs/DiagnosticArray.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <algorithm>
#include <utility>

#include "deformable_sim/ros/publishers/makers.h"

namespace deformable_sim {

namespace {

/// diagnostic_updater's Updater publishes by its own timer and whether or not anybody listens; its status wrapper is
/// used, its timer is not.
class Diagnostics : public TopicsPublisher {
 public:
  explicit Diagnostics(const PublisherContext& context) : name_(context.node_name) {
    topics_.push_back(Topic::advertise<diagnostic_msgs::DiagnosticArray>(context, "/diagnostics"));
  }

  SnapshotDetail detail() const override { return SnapshotDetail::kReports; }

  void publish(const Instant& instant) override {
    diagnostic_updater::DiagnosticStatusWrapper status;
    using Level = diagnostic_msgs::DiagnosticStatus;
    status.name = name_ + ": simulation";
    status.hardware_id = "none";
    if (!instant.failure.empty()) {
      status.summary(Level::ERROR, "stopped on its last good state: " + instant.failure);
    } else if (instant.behind) {
      status.summaryf(Level::WARN, "behind real time: factor %.2f", instant.real_time_factor);
    } else if (!instant.warnings.empty()) {
      status.summary(Level::WARN, instant.warnings.front());
    } else {
      status.summary(Level::OK, instant.paused ? "paused" : "running");
    }
    double max_strain = 0.0;
    int contacts = 0;
    for (const BodyReport& body : instant.snapshot.bodies) {
      max_strain = std::max(max_strain, body.max_strain);
      contacts += body.contacts;
    }
    status.add("simulated time (s)", instant.snapshot.time);
    status.add("real-time factor", instant.real_time_factor);
    status.add("step (s)", instant.snapshot.dt);
    status.add("mean cost of a step (s)", instant.mean_step_seconds);
    status.add("longest step (s)", instant.longest_step_seconds);
    status.add("max strain", max_strain);
    status.add("contacts", contacts);
    status.add("max penetration (m)", instant.snapshot.max_penetration);
    status.add("nodes", instant.snapshot.model->point_count());
    for (std::size_t i = 0; i < instant.warnings.size(); ++i) {
      status.add("warning " + std::to_string(i + 1), instant.warnings[i]);
    }
    diagnostic_msgs::DiagnosticArray message;
    message.header.stamp = ros::Time::now();  // consumers age entries by their own clock
    message.status.push_back(status);
    topics_[0].publish(std::move(message));
  }

 private:
  std::string name_;
};

}  // namespace

std::unique_ptr<Publisher> make_diagnostics_publisher(const PublisherContext& context) {
  return std::make_unique<Diagnostics>(context);
}

}  // namespace deformable_sim
