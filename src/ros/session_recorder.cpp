#include "deformable_sim/ros/session_recorder.h"

#include <utility>

#include "deformable_sim/core/command_archive.h"
#include "deformable_sim/core/simd_level.h"
#include "deformable_sim/scene/edit.h"

namespace deformable_sim {
namespace {

constexpr std::uint32_t kQueue = 10000;

std::vector<std::uint8_t> to_list(const std::string& bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

SessionRecorder::SessionRecorder(ros::NodeHandle nh, std::string frame_id) : frame_id_(std::move(frame_id)) {
  publisher_ = nh.advertise<msg::SessionRecord>(
      "session", kQueue, [joined = joined_](const ros::SingleSubscriberPublisher&) { ++*joined; });
}

msg::SessionRecord SessionRecorder::record(std::uint8_t kind, std::uint64_t step, ros::Time stamp) {
  msg::SessionRecord record;
  record.header.frame_id = frame_id_;
  record.header.stamp = stamp;
  record.kind = kind;
  record.step = step;
  record.number = number_++;
  return record;
}

void SessionRecorder::begin(const SceneSpec& scene, std::optional<double> running_dt, ros::Time stamp, World* world) {
  told_ = *joined_;
  begun_ = wanted();
  depends_ = false;
  if (!begun_) return;
  msg::SessionRecord r = record(msg::SessionRecord::BEGIN, world->step_count(), stamp);
  r.text = scene_text(scene);
  r.origin = scene.origin;
  r.running_dt = running_dt.value_or(0.0);
  r.machine = name_of(simd_level());
  r.data = to_list(world->save());
  publisher_.publish(r);
  if (world->settings().control.control == StepControl::kBudget) depends("step.control: budget", r.step, stamp);
}

void SessionRecorder::applied(const Command& command, std::uint64_t step, ros::Time stamp) {
  if (!tells() || std::holds_alternative<command::Reset>(command)) return;  // begin() comes after a reset
  msg::SessionRecord r = record(msg::SessionRecord::COMMAND, step, stamp);
  r.data = to_list(command_bytes(command));
  publisher_.publish(r);
}

void SessionRecorder::saved(std::uint64_t step, ros::Time stamp) {
  if (tells()) publisher_.publish(record(msg::SessionRecord::SAVE, step, stamp));
}

void SessionRecorder::stepped(std::uint64_t step, ros::Time stamp) {
  if (tells()) publisher_.publish(record(msg::SessionRecord::STEP, step, stamp));
}

void SessionRecorder::depends(const std::string& why, std::uint64_t step, ros::Time stamp) {
  if (!tells() || depends_) return;
  depends_ = true;
  msg::SessionRecord r = record(msg::SessionRecord::DEPENDS, step, stamp);
  r.text = why;
  publisher_.publish(r);
}

}  // namespace deformable_sim
