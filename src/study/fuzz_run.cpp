#include "fuzz_run.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>

#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/script.h"
#include "fuzz_commands.h"
#include "fuzz_watch.h"

namespace deformable_sim::fuzz {
namespace {

constexpr double kSlack = 1e-9;         // s
constexpr int kStepsBetweenLooks = 16;  // at the energy

/// FNV-1a over the bytes of what a step changes.
void add_bits(const Nodes& values, std::uint64_t* bits) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, values.data() + i, sizeof word);
    *bits = (*bits ^ word) * 0x100000001b3ULL;
  }
}

bool has_soft_grasps(const SceneSpec& scene, const std::vector<TimedCommand>& commands) {
  for (const GraspSpec& g : scene.grasps)
    if (g.request.stiffness > 0.0) return true;
  for (const ScriptEvent& e : scene.script) {
    const auto* grasp = std::get_if<command::Grasp>(&e.command);
    if (grasp && grasp->request.stiffness > 0.0) return true;
  }
  for (const TimedCommand& c : commands)
    if (c.word == "grasp" && !c.numbers.empty() && c.numbers.back() > 0.0) return true;
  return false;
}

/// A world and all that happens to it.
class Life {
 public:
  Life(const SceneSpec& scene, const std::vector<TimedCommand>& commands, const Limits& limits, World* world)
      : scene_(scene), commands_(commands), limits_(limits), world_(world), script_(scene.script) {}

  Outcome outcome;

  /// The same life, from now on in another world.
  Life in(World* world) const {
    Life other = *this;
    other.world_ = world;
    return other;
  }
  void limit_steps(int most) { limits_.steps = most; }

  void live() {
    const bool soft = has_soft_grasps(scene_, commands_);
    Watch watch(scene_, *world_, soft ? Watch::Grasps::kSoft : Watch::Grasps::kRigid);
    const double began = thread_cpu_time(), dt = world_->settings().dt;
    outcome.integrator = world_->settings().integrator;
    outcome.bits = 0xcbf29ce484222325ULL;
    for (; outcome.time < limits_.seconds - kSlack && outcome.steps < limits_.steps; ++outcome.steps) {
      if (disturb()) watch.disturbed();
      const State before = world_->state();
      const StepOutcome step = world_->step();
      outcome.time = (outcome.steps + 1) * dt;
      outcome.cpu = thread_cpu_time() - began;
      if (!step.ok) return stopped(step, before);
      add_bits(world_->state().x, &outcome.bits);
      add_bits(world_->state().v, &outcome.bits);
      const Finding finding = watch.look(*world_);
      // Unstable at any step but with much damping, as its warning says.
      const bool by_nature = finding.what == "far" && outcome.integrator == "explicit_euler";
      if (by_nature) return diverged(finding.detail);
      if (finding.what == "energy" && is_said()) return said(finding.detail);
      if (!finding.what.empty()) return found(finding.what, finding.detail);
      if (outcome.cpu < limits_.cpu) continue;
      outcome.end = Outcome::End::kCut;
      ++outcome.steps;
      return;
    }
  }

 private:
  /// Plays what is due. Commands come by the time since the beginning, which a reset does not turn back.
  bool disturb() {
    bool any = false;
    while (next_ < commands_.size() && commands_[next_].time <= outcome.time + kSlack) {
      const TimedCommand& c = commands_[next_++];
      if (!apply(c, world_).status.ok()) ++outcome.refused_commands;
      if (c.word == "reset") script_.restart();
      any = true;
    }
    while (const ScriptEvent* event = script_.take(world_->time())) {
      if (!world_->apply(event->command).status.ok()) ++outcome.refused_commands;
      any = true;
    }
    return any;
  }

  void found(const std::string& what, const std::string& detail) {
    outcome.end = Outcome::End::kFound;
    outcome.what = what;
    outcome.detail = detail;
  }

  void diverged(const std::string& detail) {
    outcome.end = Outcome::End::kStopped;
    outcome.what = "stop";
    outcome.detail = detail;
  }

  void said(const std::string& detail) {
    outcome.end = Outcome::End::kSaid;
    outcome.what = scene_.step.mode == SolverMode::kManual ? "energy" : kOfAuto;
    outcome.detail = detail;
  }

  /// Whether the world warns of it, by the next look of its books.
  bool is_said() {
    for (int k = 0; k <= kStepsBetweenLooks; ++k) {
      const Snapshot now = world_->snapshot();
      for (const std::string& warning : now.warnings)
        for (const char* words : {"energy from nowhere", "the step is inaccurate", "found no step"})
          if (warning.find(words) != std::string::npos) return true;
      if (!world_->step().ok) return true;
    }
    return false;
  }

  /// Not of a solid turned inside out by a command, whose law has no energy there: nothing steps that. Of one that its
  /// grasps are about to turn so the message says it.
  bool has_energy() const {
    const Snapshot now = world_->snapshot(SnapshotDetail::kReports);
    return std::all_of(now.bodies.begin(), now.bodies.end(),
                       [](const BodyReport& r) { return std::isfinite(r.elastic_energy); });
  }

  void stopped(const StepOutcome& step, const State& before) {
    outcome.detail = step.message;
    const bool same = before.x == world_->state().x && before.v == world_->state().v &&
                      before.time == world_->state().time && before.directors == world_->state().directors;
    if (!same) return found("moved_by_stop", step.message);
    const Finding finding = Watch(scene_, *world_, Watch::Grasps::kSoft).look_at_numbers(*world_);
    if (!finding.what.empty()) return found(finding.what, finding.detail + ", after a stop");
    const bool possible = has_energy() && step.message.find("inside out") == std::string::npos;
    world_->apply(command::Reset{});
    // At the very start nothing was commanded yet that could be to blame: the scene itself cannot be stepped.
    if (outcome.steps > 0 && !world_->step().ok) return found("dead_after_stop", step.message);
    if (possible && scene_.step.mode == SolverMode::kAuto) return found("stop", step.message);
    diverged(step.message);
  }

  const SceneSpec& scene_;
  const std::vector<TimedCommand>& commands_;
  Limits limits_;
  World* world_;
  Script script_;
  size_t next_ = 0;
};

template <class Work>
Outcome guarded(const Work& work) {
  Outcome outcome;
  try {
    return work();
  } catch (const InputError& error) {
    outcome.end = Outcome::End::kRefused;
    outcome.what = "refused";
    outcome.detail = error.what();
  } catch (const std::exception& error) {
    outcome.end = Outcome::End::kFound;
    outcome.what = "exception";
    outcome.detail = error.what();
  }
  return outcome;
}

/// What differs between a world that goes on after a save and one that restored it, half way; empty: nothing.
std::string compare_restored(const std::string& text, const std::string& origin, const Limits& limits) {
  const SceneSpec scene = load_scene_text(text, origin);
  const std::vector<TimedCommand> commands = commands_of(text);
  const std::unique_ptr<World> world = build_world(scene), other = build_world(scene);
  Life life(scene, commands, limits, world.get());
  life.limit_steps(limits.steps / 2);
  life.live();
  if (life.outcome.end != Outcome::End::kDone) return "";
  other->restore(world->save());
  Life restored = life.in(other.get());
  for (Life* each : {&life, &restored}) {
    each->limit_steps(limits.steps);
    each->live();
  }
  const bool same = life.outcome.bits == restored.outcome.bits && life.outcome.end == restored.outcome.end;
  return same || life.outcome.steps != restored.outcome.steps ? "" : "other bits after half the steps";
}

}  // namespace

Outcome run_case(const std::string& text, const std::string& origin, const Limits& limits) {
  return guarded([&] {
    const SceneSpec scene = load_scene_text(text, origin);
    const std::vector<TimedCommand> commands = commands_of(text);
    const std::unique_ptr<World> world = build_world(scene, limits.threads);
    if (limits.begins) {
      const std::string& name = world->settings().integrator;
      const double limit = make_integrator(name, world->settings().solver)->stability_limit();
      const bool divides = std::isfinite(limit) || name == "substepped_verlet";
      limits.begins(name, scene.step.mode == SolverMode::kManual && divides);
    }
    Life life(scene, commands, limits, world.get());
    life.live();
    return life.outcome;
  });
}

Outcome compare_case(const std::string& text, const std::string& origin, const Limits& limits) {
  const Outcome first = run_case(text, origin, limits);
  if (first.end != Outcome::End::kDone && first.end != Outcome::End::kCut) return first;
  Limits same = limits;
  same.begins = nullptr;
  same.steps = first.steps;
  same.cpu = 10.0 * limits.cpu;
  Outcome result = first;
  const auto differs = [&](const std::string& what, const Outcome& second) {
    result.cpu += second.cpu;
    if (second.bits == first.bits || second.steps < first.steps) return false;
    result.end = Outcome::End::kFound;
    result.what = what;
    result.detail = "other bits, " + first.integrator;
    return true;
  };
  if (differs("repeat", run_case(text, origin, same))) return result;
  const Outcome again = guarded([&] {
    const SceneSpec scene = load_scene_text(text, origin);
    const std::vector<TimedCommand> commands = commands_of(text);
    const std::unique_ptr<World> world = build_world(scene);
    Life(scene, commands, same, world.get()).live();
    world->apply(command::Reset{});
    Life second(scene, commands, same, world.get());
    second.live();
    return second.outcome;
  });
  if (differs("reset", again)) return result;
  same.threads = 2;
  if (differs("threads", run_case(text, origin, same))) return result;
  return guarded([&] {
    const std::string difference = compare_restored(text, origin, same);
    if (difference.empty()) return result;
    Outcome found = result;
    found.end = Outcome::End::kFound;
    found.what = "restore";
    found.detail = difference + ", " + first.integrator;
    return found;
  });
}

}  // namespace deformable_sim::fuzz
