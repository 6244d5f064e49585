// ~rollout: what-if on copies of the running simulation.
#pragma once

#include <mutex>
#include <string>

#include "deformable_sim/ros/frames.h"
#include "deformable_sim/ros/messages.h"
#include "deformable_sim/ros/scene_loader.h"
#include "deformable_sim/ros/simulation.h"

namespace deformable_sim {

/// Plans are played side by side on threads of the lowest priority, so that they have what the running world leaves.
/// Taking the copy is all that the running world is asked for. One call at a time.
class Rollouts {
 public:
  Rollouts(Simulation* simulation, const SceneLoader* loader, Frames* frames, std::string frame_id)
      : simulation_(simulation), loader_(loader), frames_(frames), frame_id_(std::move(frame_id)) {}

  /// Throws InputError for a request that is refused as a whole.
  void run(const msg::RolloutRequest& request, msg::RolloutResponse* response);

 private:
  Simulation* simulation_;
  const SceneLoader* loader_;
  Frames* frames_;
  std::string frame_id_;
  std::mutex running_;
};

}  // namespace deformable_sim
