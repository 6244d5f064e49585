#include "deformable_sim/scene/rollout.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "schema.h"

namespace deformable_sim {
namespace {

constexpr double kRounding = 1e-9;  // s

/// Trajectories of one rollout, each with its player once there is its grasp.
class Players {
 public:
  Players(const std::vector<GraspTrajectory>& trajectories, RolloutOutcome* outcome)
      : trajectories_(trajectories),
        players_(trajectories.size()),
        over_(trajectories.size(), 0),
        limited_(trajectories.size(), 0),
        outcome_(outcome) {}

  void move(World* world) {
    if (trajectories_.empty()) return;
    const std::vector<GraspReport> grasps = world->grasp_reports();
    for (size_t k = 0; k < trajectories_.size(); ++k)
      if (over_[k] == 0) move_one(k, grasps, world);
  }

 private:
  void move_one(size_t k, const std::vector<GraspReport>& grasps, World* world) {
    const GraspReport* held = find_held(grasps, trajectories_[k].grasp);
    const std::string who = "grasp '" + trajectories_[k].grasp + "': ";
    if (held == nullptr) {
      if (!players_[k]) return;
      over_[k] = 1;
      outcome_->notes.push_back(who + "lost at " + format_number(world->time()) + " s");
      return;
    }
    if (!players_[k]) players_[k].emplace(trajectories_[k], world->time(), held->world_from_grasp);
    const Reply reply = world->apply(players_[k]->move(world->time(), world->settings().dt));
    if (!reply.note.empty() && limited_[k] == 0) {
      limited_[k] = 1;
      outcome_->notes.push_back(who + reply.note);
    }
  }

  const std::vector<GraspTrajectory>& trajectories_;
  std::vector<std::optional<TrajectoryPlayer>> players_;
  std::vector<char> over_, limited_;
  RolloutOutcome* outcome_;
};

}  // namespace

RolloutOutcome play_rollout(const RolloutPlan& plan, double seconds, double sample_period, Script* script, World* world,
                            const RolloutSampler& sample, const RolloutKeeper& may_go_on) {
  RolloutOutcome outcome;
  Players players(plan.trajectories, &outcome);
  const double dt = world->settings().dt, start = world->time();
  const auto steps = std::max<std::int64_t>(1, std::llround(seconds / dt));
  const auto every = sample_period > 0.0 ? std::max<std::int64_t>(1, std::llround(sample_period / dt)) : steps;
  size_t next = 0;
  sample(*world);
  for (std::int64_t step = 1; step <= steps; ++step) {
    outcome.status = may_go_on();
    if (!outcome.status.ok()) return outcome;
    while (const ScriptEvent* event = script->take(world->time())) world->apply(event->command);
    for (; next < plan.commands.size() && plan.commands[next].time <= world->time() - start + kRounding; ++next) {
      const Reply reply = world->apply(plan.commands[next].command);
      outcome.status = reply.status;
      outcome.status.message = plan.commands[next].what + ": " + reply.status.message;
      if (!reply.status.ok()) return outcome;
      if (!reply.note.empty()) outcome.notes.push_back(plan.commands[next].what + ": " + reply.note);
    }
    players.move(world);
    const StepOutcome made = world->step();
    outcome.status = made.ok ? Status() : Status{Code::kInternal, made.message};
    if (!made.ok) return outcome;
    if (step % every == 0 || step == steps) sample(*world);
  }
  return outcome;
}

}  // namespace deformable_sim
