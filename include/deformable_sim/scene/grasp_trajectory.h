// Grasps along timed poses: what the follow_trajectory action and rollouts play.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/command.h"
#include "deformable_sim/core/snapshot.h"

namespace deformable_sim {

struct GraspWaypoint {
  double time = 0.0;  // s from the start
  Pose world_from_grasp = Pose::Identity();
};

struct GraspTrajectory {
  std::string grasp;
  std::vector<GraspWaypoint> points;  // at least one, times ascending
};

/// Throws InputError where there is no point, or times do not ascend from 0 on.
void check_trajectory(const GraspTrajectory& trajectory);

/// One trajectory being played: asked before every step for where the grasp has to be at its end, so that waypoints are
/// met at the ends of steps whatever their times are.
class TrajectoryPlayer {
 public:
  /// start: simulated time; world_from_grasp: where the first stretch begins.
  TrajectoryPlayer(GraspTrajectory trajectory, double start, const Pose& world_from_grasp);

  /// For a step from `time` to time + dt.
  command::MoveGrasp move(double time, double dt) const;
  /// p(t) straight between waypoints, q(t) slerped; before the first stretch the start, after the last the end.
  Pose desired(double time) const;
  const Pose& goal() const { return points_.back().world_from_grasp; }
  double end() const { return start_ + points_.back().time; }
  const std::string& grasp() const { return grasp_; }

 private:
  std::string grasp_;
  std::vector<GraspWaypoint> points_;  // the start first
  double start_;
};

/// Which of the reports is that of the grasp; null when it is gone or has slipped.
const GraspReport* find_held(const std::vector<GraspReport>& grasps, const std::string& name);

}  // namespace deformable_sim
