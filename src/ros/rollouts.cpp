#include "deformable_sim/ros/rollouts.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include <ros/init.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "deformable_sim/ros/convert.h"
#include "deformable_sim/ros/grasp_requests.h"
#include "deformable_sim/ros/state_messages.h"
#include "deformable_sim/ros/trajectories.h"
#include "deformable_sim/scene/rollout.h"

namespace deformable_sim {

namespace {

constexpr std::size_t kMostPlans = 256;
constexpr std::size_t kMostCommands = 10000;  // of a plan
constexpr double kMostSteps = 1e6;            // of all plans together
constexpr double kMostSamples = 1e5;
constexpr double kMostNumbers = 3e7;  // of positions and velocities in one answer
constexpr int kLowestPriority = 19;

using Clock = std::chrono::steady_clock;

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<TimedCommand> to_timed(const msg::TimedGraspCommand& message, const std::string& what, Frames* frames) {
  if (!message.command.follow_frame.empty())
    throw InputError(what + ".command.follow_frame: nothing follows tf on a copy; give a trajectory");
  const double time = to_non_negative(message.time.toSec(), what + ".time");
  std::vector<TimedCommand> timed;
  for (Command& command : to_commands(message.command, frames)) {
    if (auto* move = std::get_if<command::MoveGrasp>(&command))
      move->duration = to_non_negative(message.duration.toSec(), what + ".duration");
    timed.push_back({time, std::move(command), what});
  }
  return timed;
}

RolloutPlan to_plan(const msg::RolloutPlan& message, const std::string& what, Frames* frames) {
  RolloutPlan plan;
  if (message.commands.size() > kMostCommands)
    throw InputError(what + ".commands: more than " + std::to_string(kMostCommands), Code::kOutOfRange);
  for (std::size_t k = 0; k < message.commands.size(); ++k) {
    const std::string here = what + ".commands[" + std::to_string(k) + "]";
    if (k > 0 && message.commands[k].time < message.commands[k - 1].time)
      throw InputError(here + ".time: before that of the command before");
    for (TimedCommand& timed : to_timed(message.commands[k], here, frames)) plan.commands.push_back(std::move(timed));
  }
  plan.trajectories = to_trajectories(message.trajectories, what + ".trajectories", frames);
  return plan;
}

void check_size(const msg::RolloutRequest& request, double dt, int nodes) {
  if (request.plans.empty()) throw InputError("plans: none; one without commands only waits");
  if (request.plans.size() > kMostPlans) throw InputError("plans: at most 256", Code::kOutOfRange);
  const double seconds = to_non_negative(request.seconds, "seconds");
  const double period = to_non_negative(request.sample_period, "sample_period");
  to_non_negative(request.deadline, "deadline");
  if (seconds == 0.0) throw InputError("seconds: must be more than 0", Code::kOutOfRange);
  const double plans = static_cast<double>(request.plans.size());
  if (plans * seconds / dt > kMostSteps) throw InputError("more than 1000000 steps in one call", Code::kOutOfRange);
  const double samples = plans * (2.0 + (period > 0.0 ? seconds / std::max(period, dt) : 0.0));
  if (samples > kMostSamples) throw InputError("more than 100000 samples in one call", Code::kOutOfRange);
  if (request.with_positions && samples * nodes * 6.0 > kMostNumbers)
    throw InputError("more than 3e7 positions and velocities in one answer: fewer plans, a longer sample_period",
                     Code::kOutOfRange);
}

/// Plays plans on copies; one object a call.
class Player {
 public:
  Player(const msg::RolloutRequest& request, const Fork& fork, const SceneLoader& loader, const std::string& frame_id)
      : request_(request), fork_(fork), loader_(loader), frame_id_(frame_id), began_(Clock::now()) {}

  void play(const std::vector<RolloutPlan>& plans, std::vector<msg::RolloutResult>* results) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      // The priority of a thread is Linux's; elsewhere that of the process would change.
      setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kLowestPriority);
      for (std::size_t k = next++; k < plans.size(); k = next++) play_one(plans[k], &(*results)[k]);
    };
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < std::min(cores, plans.size()); ++k) threads.emplace_back(work);
    for (std::thread& thread : threads) thread.join();
  }

 private:
  void play_one(const RolloutPlan& plan, msg::RolloutResult* result) const {
    const double before = cpu_seconds();
    try {
      const std::unique_ptr<World> world = loader_.copy_of(fork_);
      Script script = fork_.script;
      const RolloutOutcome outcome = play_rollout(
          plan, request_.seconds, request_.sample_period, &script, world.get(),
          [&](const World& now) { result->samples.push_back(sample(now)); }, [this] { return may_go_on(); });
      fill(outcome.status, &result->status);
      result->warnings = world->snapshot().warnings;
      result->warnings.insert(result->warnings.end(), outcome.notes.begin(), outcome.notes.end());
    } catch (const InputError& error) {
      fill(Status{error.code(), error.what()}, &result->status);
    } catch (const std::exception& error) {
      fill(Status{Code::kInternal, error.what()}, &result->status);
    }
    result->cpu_seconds = cpu_seconds() - before;
  }

  Status may_go_on() const {
    if (ros::isShuttingDown()) return {Code::kUnavailable, "the node is shutting down"};
    const double seconds = std::chrono::duration<double>(Clock::now() - began_).count();
    if (request_.deadline > 0.0 && seconds > request_.deadline) return {Code::kTimeout, "the deadline has passed"};
    return {};
  }

  msg::RolloutSample sample(const World& world) const {
    Snapshot snapshot = world.snapshot();
    if (request_.with_contacts) snapshot.contacts = world.contact_reports();
    const ros::Time stamp = fork_.stamp + ros::Duration(world.time() - fork_.time);
    msg::RolloutSample sample;
    sample.header.frame_id = frame_id_;
    sample.header.stamp = stamp;
    for (std::size_t b = 0; b < snapshot.model->bodies.size(); ++b) {
      sample.bodies.push_back(body_state_message(snapshot, static_cast<int>(b), frame_id_, stamp));
      if (request_.with_positions) continue;
      sample.bodies.back().positions = {};
      sample.bodies.back().velocities = {};
      sample.bodies.back().segments = {};
    }
    sample.grasps = grasp_state_messages(snapshot, frame_id_, stamp);
    if (request_.with_contacts) sample.contacts = contact_messages(snapshot);
    return sample;
  }

  const msg::RolloutRequest& request_;
  const Fork& fork_;
  const SceneLoader& loader_;
  const std::string& frame_id_;
  Clock::time_point began_;
};

}  // namespace

void Rollouts::run(const msg::RolloutRequest& request, msg::RolloutResponse* response) {
  const std::unique_lock<std::mutex> lock(running_, std::try_to_lock);
  if (!lock) throw InputError("another rollout is being played", Code::kUnavailable);
  check_size(request, simulation_->dt(), simulation_->model()->node_count());
  std::vector<RolloutPlan> plans;
  for (std::size_t k = 0; k < request.plans.size(); ++k)
    plans.push_back(to_plan(request.plans[k], "plans[" + std::to_string(k) + "]", frames_));
  Fork fork;
  const Reply reply = simulation_->fork(&fork);
  if (!reply.status.ok()) throw InputError(reply.status.message, reply.status.code);
  response->results.resize(plans.size());
  Player(request, fork, *loader_, frame_id_).play(plans, &response->results);
}

}  // namespace deformable_sim
