#include "deformable_sim/core/frame_motion.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

double angle_between(const Pose& a, const Pose& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

Pose interpolate(const Pose& a, const Pose& b, double fraction) {
  Pose pose = Pose::Identity();
  pose.translation() = a.translation() + fraction * (b.translation() - a.translation());
  const Eigen::Quaterniond q = Eigen::Quaterniond(a.linear()).slerp(fraction, Eigen::Quaterniond(b.linear()));
  pose.linear() = q.normalized().toRotationMatrix();
  return pose;
}

}  // namespace

void FrameMotion::move_to(const Pose& target, double duration) {
  start_ = pose_;
  target_ = target;
  duration_ = duration;
  elapsed_ = 0.0;
  moving_ = true;
}

void FrameMotion::stop() {
  target_ = pose_;
  moving_ = false;
}

double FrameMotion::travel(const Pose& from, const Pose& to, double lever) {
  return (to.translation() - from.translation()).norm() + lever * angle_between(from, to);
}

bool FrameMotion::advance(double dt, double max_speed, double lever) {
  if (!moving_) return true;
  elapsed_ += dt;
  // The last fraction of a step counts as arrived: durations are multiples of dt only up to rounding.
  const bool due = elapsed_ >= duration_ - 1e-9 * dt;
  const Pose desired = due ? target_ : interpolate(start_, target_, elapsed_ / duration_);
  const double way = travel(pose_, desired, lever);
  const double allowed = max_speed * dt;
  if (way > allowed * (1.0 + 1e-12)) {
    pose_ = interpolate(pose_, desired, allowed / way);
    return false;
  }
  pose_ = desired;
  moving_ = !due;
  return true;
}

void FrameMotion::pass(Archive* archive) {
  archive->pass(&pose_);
  archive->pass(&start_);
  archive->pass(&target_);
  archive->pass(&duration_);
  archive->pass(&elapsed_);
  archive->pass(&moving_);
}

bool is_valid_pose(const Pose& pose) {
  if (!pose.matrix().allFinite() || pose.translation().cwiseAbs().maxCoeff() > 1e6) return false;
  const Mat3 r = pose.linear();
  return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-6 && r.determinant() > 0.0;
}

}  // namespace deformable_sim
