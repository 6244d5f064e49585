#include "deformable_sim/ros/trajectories.h"

#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

constexpr std::size_t kMostPoints = 100000;
constexpr std::size_t kMostTrajectories = 1000;

}  // namespace

GraspTrajectory to_trajectory(const msg::GraspTrajectory& message, const std::string& what, Frames* frames) {
  check_name(what + ".grasp", message.grasp);
  if (message.points.size() > kMostPoints)
    throw InputError(what + ".points: more than " + std::to_string(kMostPoints), Code::kOutOfRange);
  const Pose world_from_frame = frames->resolve(message.header.frame_id);
  GraspTrajectory trajectory;
  trajectory.grasp = message.grasp;
  for (std::size_t k = 0; k < message.points.size(); ++k) {
    const std::string point = what + ".points[" + std::to_string(k) + "]";
    const Pose pose = to_pose(message.points[k].pose, point + ".pose");
    trajectory.points.push_back({message.points[k].time_from_start.toSec(), world_from_frame * pose});
  }
  check_trajectory(trajectory);
  return trajectory;
}

std::vector<GraspTrajectory> to_trajectories(const std::vector<msg::GraspTrajectory>& messages, const std::string& what,
                                             Frames* frames) {
  if (messages.size() > kMostTrajectories)
    throw InputError(what + ": more than " + std::to_string(kMostTrajectories), Code::kOutOfRange);
  std::vector<GraspTrajectory> trajectories;
  for (std::size_t k = 0; k < messages.size(); ++k)
    trajectories.push_back(to_trajectory(messages[k], what + "[" + std::to_string(k) + "]", frames));
  return trajectories;
}

}  // namespace deformable_sim
