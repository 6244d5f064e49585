#include "deformable_sim/scene/trajectory_follower.h"

#include <algorithm>
#include <set>
#include <utility>

#include "schema.h"

namespace deformable_sim {
namespace {

constexpr double kRounding = 1e-9;  // s

double angle_between(const Pose& a, const Pose& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

void show(const GraspReport& report, const TrajectoryPlayer& player, double time, GraspProgress* progress) {
  progress->desired = player.desired(time);
  progress->actual = report.world_from_grasp;
  progress->position_error = (progress->actual.translation() - progress->desired.translation()).norm();
  progress->force = report.force.norm();
  progress->load = report.load;
}

}  // namespace

TrajectoryFollower::TrajectoryFollower(TrajectoryGoal goal, const World& world)
    : goal_(std::move(goal)), start_(world.time()) {
  if (goal_.trajectories.empty()) throw InputError("trajectories: none");
  const std::vector<GraspReport> grasps = world.grasp_reports();
  std::set<std::string> seen;
  for (const GraspTrajectory& trajectory : goal_.trajectories) {
    check_trajectory(trajectory);
    if (!seen.insert(trajectory.grasp).second)
      throw InputError("trajectories: two of grasp '" + trajectory.grasp + "'", Code::kAlreadyExists);
    const GraspReport* held = find_held(grasps, trajectory.grasp);
    if (held == nullptr) {
      std::vector<std::string> known;
      for (const GraspReport& grasp : grasps)
        if (grasp.phase != GraspPhase::kSlipped) known.push_back(grasp.name);
      throw InputError(
          "no grasp named '" + trajectory.grasp + "' that holds; there are: " + (known.empty() ? "none" : join(known)),
          Code::kNotFound);
    }
    if (!held->follow_frame.empty())
      throw InputError("'" + trajectory.grasp + "' follows tf frame " + held->follow_frame + " and takes no targets");
    players_.emplace_back(trajectory, start_, held->world_from_grasp);
    end_ = std::max(end_, players_.back().end());
    GraspProgress progress;
    progress.grasp = trajectory.grasp;
    show(*held, players_.back(), start_, &progress);
    progress_.grasps.push_back(std::move(progress));
  }
}

bool TrajectoryFollower::moves(const std::string& grasp) const {
  return std::any_of(progress_.grasps.begin(), progress_.grasps.end(),
                     [&](const GraspProgress& g) { return g.grasp == grasp && !g.is_over; });
}

void TrajectoryFollower::before_step(World* world) {
  for (size_t k = 0; k < players_.size(); ++k)
    if (!progress_.grasps[k].is_over) world->apply(players_[k].move(world->time(), world->settings().dt));
}

void TrajectoryFollower::after_step(World* world) {
  if (progress_.is_over) return;
  const double time = world->time();
  progress_.time_from_start = time - start_;
  progress_.progress = end_ > start_ ? std::min(1.0, (time - start_) / (end_ - start_)) : 1.0;
  const std::vector<GraspReport> grasps = world->grasp_reports();
  bool all_over = true;
  for (size_t k = 0; k < players_.size(); ++k) {
    GraspProgress& progress = progress_.grasps[k];
    if (progress.is_over) continue;
    const GraspReport* held = find_held(grasps, progress.grasp);
    if (held == nullptr) {
      lose(k, time, world);
      if (progress_.is_over) return;
      continue;
    }
    show(*held, players_[k], time, &progress);
    const bool is_there = progress.position_error <= goal_.position_tolerance &&
                          angle_between(progress.actual, players_[k].goal()) <= goal_.rotation_tolerance;
    if (time >= players_[k].end() - kRounding && is_there) {
      progress.is_over = true;
      progress.outcome = TrajectoryOutcome::kReached;
    } else if (time > players_[k].end() + goal_.time_tolerance) {
      stop({Code::kTimeout, "grasp '" + progress.grasp + "' is " + format_number(progress.position_error) +
                                " m from its last pose " + format_number(goal_.time_tolerance) +
                                " s after its time; max_speed may limit it"},
           world);
      return;
    }
    all_over = all_over && progress.is_over;
  }
  if (all_over) finish(time, world);
}

void TrajectoryFollower::lose(size_t k, double time, World* world) {
  progress_.grasps[k].is_over = true;
  progress_.grasps[k].outcome = TrajectoryOutcome::kLost;
  if (goal_.allow_partial) return;
  stop({Code::kUnavailable,
        "grasp '" + progress_.grasps[k].grasp + "' was lost at " + format_number(time) + " s; the others stopped"},
       world);
}

void TrajectoryFollower::finish(double time, World* world) {
  std::vector<std::string> lost;
  for (const GraspProgress& progress : progress_.grasps)
    if (progress.outcome == TrajectoryOutcome::kLost) lost.push_back(progress.grasp);
  if (lost.empty()) {
    progress_.is_over = true;
    return;
  }
  stop({Code::kUnavailable,
        "lost: " + join(lost) + "; the others have reached their last poses by " + format_number(time) + " s"},
       world);
}

void TrajectoryFollower::stop(const Status& why, World* world) {
  for (GraspProgress& progress : progress_.grasps) {
    if (progress.is_over) continue;
    progress.is_over = true;
    if (world == nullptr) continue;
    const std::vector<GraspReport> grasps = world->grasp_reports();
    if (const GraspReport* held = find_held(grasps, progress.grasp))
      world->apply(command::MoveGrasp{progress.grasp, held->world_from_grasp, 0.0});
  }
  progress_.is_over = true;
  progress_.status = why;
}

}  // namespace deformable_sim
