#include "deformable_sim/ros/frames.h"

#include <thread>
#include <utility>

#include <ros/init.h>
#include <tf2/exceptions.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/transforms.h"

namespace deformable_sim {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kConnecting = std::chrono::seconds(1);
constexpr auto kPoll = std::chrono::milliseconds(2);

}  // namespace

Frames::Frames(std::string world_frame, double timeout) : world_frame_(std::move(world_frame)), timeout_(timeout) {}

Frames::~Frames() = default;

void Frames::open() {
  const std::lock_guard<std::mutex> lock(opening_);
  if (listening_) return;
  listener_ = std::make_unique<Transforms>();
  opened_at_ = Clock::now();
  listening_ = true;
}

Pose Frames::resolve(const std::string& frame) {
  if (frame.empty() || frame == world_frame_) return Pose::Identity();
  open();
  // ros::Time may stand still (a paused /clock), so the wait is by a clock of our own.
  const auto timeout = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_));
  const auto deadline = std::max(Clock::now() + timeout, opened_at_ + kConnecting);
  while (true) {
    if (const auto pose = latest(frame)) return pose->world_from_frame;
    if (Clock::now() >= deadline || !ros::ok()) break;
    std::this_thread::sleep_for(kPoll);
  }
  throw InputError("tf frame '" + printable(frame) + "': no transform to '" + world_frame_ + "' within " +
                       std::to_string(timeout_) + " s",
                   Code::kUnavailable);
}

std::optional<FramePose> Frames::latest(const std::string& frame) const {
  if (!listening_) return std::nullopt;
  if (!listener_->buffer().canTransform(world_frame_, frame, ros::Time(0))) return std::nullopt;
  try {
    const auto transform = listener_->buffer().lookupTransform(world_frame_, frame, ros::Time(0));
    FramePose result;
    if (!to_pose(transform.transform, &result.world_from_frame)) return std::nullopt;
    result.stamp = transform.header.stamp;
    return result;
  } catch (const tf2::TransformException&) {
    return std::nullopt;  // the buffer was cleared in between: time jumped back
  }
}

void Frames::forget() {
  if (listening_) listener_->forget();
}

}  // namespace deformable_sim
