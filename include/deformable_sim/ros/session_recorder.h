// ~session: everything that a replay needs, for whoever records it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "deformable_sim/core/world.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Costs nothing while nobody listens. A listener that comes gets the whole simulation first, for which World::save()
/// is called: from there on the world goes on to bits of its own, within its solver's tolerance. Records are sent in
/// order and numbered; a listener that is slower than 10,000 of them finds a number missing.
///
/// All but the constructor belong to the simulation thread.
class SessionRecorder {
 public:
  /// Advertises (network).
  SessionRecorder(ros::NodeHandle nh, std::string frame_id);

  /// Whether somebody came who has not been told of the world.
  bool has_newcomer() const { return *joined_ != told_ && wanted(); }
  /// The world there is now, whatever was before.
  void begin(const SceneSpec& scene, std::optional<double> running_dt, ros::Time stamp, World* world);
  void applied(const Command& command, std::uint64_t step, ros::Time stamp);
  void saved(std::uint64_t step, ros::Time stamp);
  void stepped(std::uint64_t step, ros::Time stamp);
  /// Once a world.
  void depends(const std::string& why, std::uint64_t step, ros::Time stamp);

 private:
  bool wanted() const { return publisher_.getNumSubscribers() > 0; }
  bool tells() const { return begun_ && wanted(); }
  msg::SessionRecord record(std::uint8_t kind, std::uint64_t step, ros::Time stamp);

  std::string frame_id_;
  std::shared_ptr<std::atomic<unsigned>> joined_ = std::make_shared<std::atomic<unsigned>>(0);
  ros::Publisher publisher_;
  unsigned told_ = 0;
  bool begun_ = false, depends_ = false;
  std::uint64_t number_ = 0;
};

}  // namespace deformable_sim
