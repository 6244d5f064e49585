// What if: grasps played on a copy of a world.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/grasp_trajectory.h"
#include "deformable_sim/scene/script.h"

namespace deformable_sim {

struct TimedCommand {
  double time = 0.0;  // s from the start
  Command command;
  std::string what;  // leads messages
};

struct RolloutPlan {
  std::vector<TimedCommand> commands;         // in the order of their times
  std::vector<GraspTrajectory> trajectories;  // each from the start on, or from when there is its grasp
};

struct RolloutOutcome {
  Status status;  // of the first command that was refused or the step that failed; nothing is played after it
  std::vector<std::string> notes;
};

/// Told after the samples' steps, and before the first step.
using RolloutSampler = std::function<void(const World&)>;
/// Asked before every step: a status that is not OK ends the rollout.
using RolloutKeeper = std::function<Status()>;

/// Steps the world by `seconds` (to the nearest step, at least one), playing its script and the plan. sample_period in
/// s, to the nearest step; 0: the start and the end alone.
RolloutOutcome play_rollout(const RolloutPlan& plan, double seconds, double sample_period, Script* script, World* world,
                            const RolloutSampler& sample, const RolloutKeeper& may_go_on);

}  // namespace deformable_sim
