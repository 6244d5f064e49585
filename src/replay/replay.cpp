#include "replay.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "deformable_sim/core/command_archive.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/simd_level.h"
#include "deformable_sim/ros/force_plugins.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

std::string to_bytes(const std::vector<std::uint8_t>& data) {
  return {data.begin(), data.end()};
}

/// Those that move with tf were added and moved by commands.
void leave_out_attached(SceneSpec* spec) {
  spec->colliders.erase(std::remove_if(spec->colliders.begin(), spec->colliders.end(),
                                       [](const ColliderSpec& c) { return !c.collider.frame.empty(); }),
                        spec->colliders.end());
}

}  // namespace

ReplayResult Replay::run(const std::function<void(double)>& progress) {
  const auto& records = recording_.records;
  for (size_t k = 0; k < records.size(); ++k) {
    const msg::SessionRecord& record = records[k];
    if (record.kind == msg::SessionRecord::BEGIN) {
      begin(record);
    } else {
      step_to(record.step);
    }
    if (record.kind == msg::SessionRecord::COMMAND) apply(record);
    if (record.kind == msg::SessionRecord::SAVE) world_->save();
    if (record.kind == msg::SessionRecord::DEPENDS && repeats_) {
      repeats_ = false;
      result_.depends = record.text + ", from step " + std::to_string(record.step) + " on";
    }
    if (repeats_) compare(record.header.stamp);
    progress(static_cast<double>(k + 1) / static_cast<double>(records.size()));
  }
  conclude();
  return result_;
}

void Replay::begin(const msg::SessionRecord& record) {
  SceneSpec spec = load_scene_text(record.text, record.origin);
  leave_out_attached(&spec);
  const std::optional<double> running_dt =
      record.running_dt > 0.0 ? std::optional<double>(record.running_dt) : std::nullopt;
  world_ = build_world(spec, threads_, std::make_shared<ForcePlugins>(), running_dt);
  world_->restore(to_bytes(record.data));
  if (world_->step_count() != record.step) throw InputError("a beginning that is not where it says");
  if (record.machine != name_of(simd_level())) result_.machine = record.machine;
  repeats_ = true;
  ++result_.sessions;
}

void Replay::step_to(std::uint64_t step) {
  if (!repeats_) return;
  while (world_->step_count() < step) {
    const StepOutcome outcome = world_->step();
    if (!outcome.ok)
      throw InputError("step " + std::to_string(step) + " was made when it was recorded: " + outcome.message);
    ++result_.steps;
  }
  if (world_->step_count() > step) throw InputError("records that go back in time");
}

void Replay::apply(const msg::SessionRecord& record) {
  const Command command = read_command(to_bytes(record.data), world_->snapshot().colliders);
  ++result_.commands;
  if (!repeats_) return;
  const Reply reply = world_->apply(command);
  if (!reply.status.ok())
    throw InputError("a command at step " + std::to_string(record.step) + " is refused: " + reply.status.message);
}

/// A stamp may belong to several states: before and after commands, and in simulated time after a reset.
void Replay::compare(ros::Time stamp) {
  const auto range = recording_.states.equal_range(stamp);
  for (auto it = range.first; it != range.second; ++it) {
    Seen& seen = seen_[&it->second];
    if (seen.found == Found::kEqual) continue;
    const std::string text = difference(it->second, stamp);
    seen.found = text.empty() ? Found::kEqual : Found::kDifferent;
    seen.difference = text;
  }
}

/// Empty: none.
std::string Replay::difference(const RecordedState& state, ros::Time stamp) const {
  const Model& model = world_->model();
  const int index = model.find_body(state.body);
  char text[200];
  const auto at = [&] { return "'" + state.body + "' at step " + std::to_string(world_->step_count()); };
  if (index < 0) return at() + ": there is no such body";
  const Body& body = model.bodies[static_cast<size_t>(index)];
  if (state.x.cols() != body.node_count || state.v.cols() != body.node_count) return at() + ": another number of nodes";
  const auto x = world_->state().x.middleCols(body.first_node, body.node_count);
  const auto v = world_->state().v.middleCols(body.first_node, body.node_count);
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    if (x.col(i) == state.x.col(i) && v.col(i) == state.v.col(i)) continue;
    std::snprintf(text, sizeof text, " (%.9g s, stamp %.9f): node %ld is %.3g m and %.3g m/s from what was recorded",
                  world_->time(), stamp.toSec(), static_cast<long>(i), (x.col(i) - state.x.col(i)).norm(),
                  (v.col(i) - state.v.col(i)).norm());
    return at() + text;
  }
  return "";
}

void Replay::conclude() {
  for (const auto& [stamp, state] : recording_.states) {
    const auto found = seen_.find(&state);
    if (found == seen_.end()) {
      ++result_.uncovered;
    } else if (found->second.found == Found::kEqual) {
      ++result_.equal;
    } else {
      if (result_.different++ == 0) result_.first_difference = found->second.difference;
    }
  }
}

}  // namespace deformable_sim
