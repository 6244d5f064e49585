#include "deformable_sim/scene/grasp_trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deformable_sim {

void check_trajectory(const GraspTrajectory& trajectory) {
  const std::string who = "trajectory of '" + trajectory.grasp + "': ";
  if (trajectory.points.empty()) throw InputError(who + "no points");
  double last = -1.0;
  for (size_t k = 0; k < trajectory.points.size(); ++k) {
    const double time = trajectory.points[k].time;
    const bool follows = k == 0 ? time >= 0.0 : time > last;
    if (!std::isfinite(time) || !follows) {
      throw InputError(who + "points[" + std::to_string(k) +
                       "].time_from_start: times begin at 0 or later, and ascend");
    }
    last = time;
  }
}

TrajectoryPlayer::TrajectoryPlayer(GraspTrajectory trajectory, double start, const Pose& world_from_grasp)
    : grasp_(std::move(trajectory.grasp)), points_(std::move(trajectory.points)), start_(start) {
  if (points_.front().time > 0.0) points_.insert(points_.begin(), {0.0, world_from_grasp});
}

command::MoveGrasp TrajectoryPlayer::move(double time, double dt) const {
  return {grasp_, desired(time + dt), dt};
}

Pose TrajectoryPlayer::desired(double time) const {
  const double t = time - start_;
  const auto after = std::upper_bound(points_.begin(), points_.end(), t,
                                      [](double value, const GraspWaypoint& point) { return value < point.time; });
  if (after == points_.begin()) return points_.front().world_from_grasp;
  if (after == points_.end()) return points_.back().world_from_grasp;
  const GraspWaypoint &from = *(after - 1), &to = *after;
  const double part = (t - from.time) / (to.time - from.time);
  Pose pose = Pose::Identity();
  pose.translation() = (1.0 - part) * from.world_from_grasp.translation() + part * to.world_from_grasp.translation();
  const Eigen::Quaterniond a(from.world_from_grasp.linear()), b(to.world_from_grasp.linear());
  pose.linear() = a.slerp(part, b).toRotationMatrix();
  return pose;
}

const GraspReport* find_held(const std::vector<GraspReport>& grasps, const std::string& name) {
  for (const GraspReport& grasp : grasps)
    if (grasp.name == name) return grasp.phase == GraspPhase::kSlipped ? nullptr : &grasp;
  return nullptr;
}

}  // namespace deformable_sim
