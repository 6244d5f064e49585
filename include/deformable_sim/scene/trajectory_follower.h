// Grasps of a running world moved along timed poses, until all are there, one is lost or somebody stops them.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/world.h"
#include "deformable_sim/scene/grasp_trajectory.h"

namespace deformable_sim {

struct TrajectoryGoal {
  std::vector<GraspTrajectory> trajectories;
  bool allow_partial = false;        // others go on when a grasp is lost
  double position_tolerance = 1e-3;  // m, at the end
  double rotation_tolerance = 1e-2;  // rad
  double time_tolerance = 1.0;       // s that a grasp may be late
};

enum class TrajectoryOutcome { kReached, kLost, kStopped };

struct GraspProgress {
  std::string grasp;
  Pose desired = Pose::Identity(), actual = Pose::Identity();
  double position_error = 0.0;  // m
  double force = 0.0;           // N
  double load = 0.0;
  bool is_over = false;
  TrajectoryOutcome outcome = TrajectoryOutcome::kStopped;  // once it is over
};

struct TrajectoryProgress {
  double time_from_start = 0.0;  // s
  double progress = 0.0;         // 0 ... 1, of the time
  std::vector<GraspProgress> grasps;
  bool is_over = false;
  Status status;  // once it is over; OK: all have reached their last poses
};

/// Whoever steps the world calls before_step() and after_step() around each step.
class TrajectoryFollower {
 public:
  /// Throws InputError: no trajectories, two of one grasp, points out of order, or no such grasp in the world.
  TrajectoryFollower(TrajectoryGoal goal, const World& world);

  void before_step(World* world);
  void after_step(World* world);
  /// Why, and grasps stop where they are; no world: it is another one by now.
  void stop(const Status& why, World* world);
  bool moves(const std::string& grasp) const;
  const TrajectoryProgress& progress() const { return progress_; }

 private:
  void lose(size_t k, double time, World* world);
  void finish(double time, World* world);

  TrajectoryGoal goal_;
  std::vector<TrajectoryPlayer> players_;
  double start_;
  double end_ = 0.0;
  TrajectoryProgress progress_;
};

}  // namespace deformable_sim
