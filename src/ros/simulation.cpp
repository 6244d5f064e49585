#include "deformable_sim/ros/simulation.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include <ros/console.h>
#include <ros/init.h>

#include "deformable_sim/ros/real_time_priority.h"

namespace deformable_sim {

namespace {

constexpr double kDeadline = 5.0;        // s (wall) until a request that nobody gets to is taken back
constexpr double kIdleWait = 0.1;        // s: how soon a newcomer sees a paused world
constexpr double kUnshownWait = 0.005;   // s
constexpr double kBudgetWhenLate = 0.8;  // CPU s per simulated s, at most
constexpr double kLeastBudget = 0.01;
constexpr double kLeastPart = 0.5;       // of the budget, that is left of it a second later
constexpr double kBudgetRegained = 1.1;  // in a second in which real time was held
constexpr double kToleratedLoss = 0.02;  // of simulated time, before real time counts as not held

double seconds_since(SpeedMeter::Clock::time_point begin) {
  return std::chrono::duration<double>(SpeedMeter::Clock::now() - begin).count();
}

Reply refused(Code code, const std::string& message) {
  Reply reply;
  reply.status = {code, message};
  return reply;
}

const char* name_of(BodyKind kind) {
  switch (kind) {
    case BodyKind::kCloth:
      return "cloth";
    case BodyKind::kRope:
      return "rope";
    case BodyKind::kSoft:
      return "soft";
  }
  return "";
}

}  // namespace

/// Steps that somebody waits for.
struct Simulation::StepRun {
  std::uint32_t wanted = 0;
  std::mutex mutex;
  std::condition_variable finished;
  bool done = false;
  StepAnswer answer;
};

void TrajectoryRun::tell(const TrajectoryProgress& progress, ros::Time stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  progress_ = progress;
  stamp_ = stamp;
  if (progress_.is_over) over_.notify_all();
}

TrajectoryProgress TrajectoryRun::wait(double seconds, ros::Time* stamp) {
  std::unique_lock<std::mutex> lock(mutex_);
  over_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return progress_.is_over; });
  *stamp = stamp_;
  return progress_;
}

Simulation::Simulation(const Parameters& parameters, Frames* frames, Warnings* warnings, SessionRecorder* recorder)
    : parameters_(parameters),
      frames_(frames),
      warnings_(warnings),
      recorder_(recorder),
      pacer_(parameters.clock, parameters.publish_clock),
      follower_(*frames, warnings),
      paused_(parameters.start_paused) {}

Simulation::~Simulation() {
  stop();
}

void Simulation::start(LoadedScene scene, NamesChanged names_changed, TimeChanged time_changed) {
  names_changed_ = std::move(names_changed);
  time_changed_ = std::move(time_changed);
  scene_ = std::move(scene);
  begin_world();
  thread_ = std::thread([this] { run(); });
}

void Simulation::stop() {
  stopping_ = true;
  queue_.close();
  if (thread_.joinable()) thread_.join();
}

Reply Simulation::apply(std::vector<Command> commands) {
  return queue_.call([this, commands = std::move(commands)] { return all_now(commands); }, kDeadline);
}

void Simulation::post(std::vector<Command> commands, Done done) {
  queue_.post([this, commands = std::move(commands)] { return all_now(commands); }, std::move(done));
}

Reply Simulation::attach(const Collider& collider, const Pose& frame_from_collider) {
  return queue_.call([=] { return attach_now(collider, frame_from_collider); }, kDeadline);
}

void Simulation::post_attach(const Collider& collider, const Pose& frame_from_collider, Done done) {
  queue_.post([=] { return attach_now(collider, frame_from_collider); }, std::move(done));
}

Reply Simulation::pause(bool paused) {
  return queue_.call(
      [this, paused] {
        if (!paused && !failure_.empty()) {
          return refused(Code::kUnavailable,
                         "the simulation failed (" + failure_ + "); ~reset, ~restore_state or ~load_scene first");
        }
        if (!paused && paused_) pacer_.restart(scene_.world->time());
        paused_ = paused;
        if (!paused) warnings_->clear("behind");
        ++version_;
        return Reply();
      },
      kDeadline);
}

Reply Simulation::reset() {
  return queue_.call(
      [this] {
        end_steps({Code::kUnavailable, "the simulation was reset"});
        end_trajectories({Code::kUnavailable, "the simulation was reset"}, scene_.world.get());
        return apply_now(command::Reset{});
      },
      kDeadline);
}

Reply Simulation::replace(LoadedScene scene) {
  // The old world is destroyed here, not on the simulation thread.
  const auto box = std::make_shared<LoadedScene>(std::move(scene));
  return queue_.call(
      [this, box] {
        end_steps({Code::kUnavailable, "another scene was loaded"});
        end_trajectories({Code::kUnavailable, "another scene was loaded"}, nullptr);
        std::swap(scene_, *box);
        begin_world();
        return Reply();
      },
      kDeadline);
}

Reply Simulation::change(LoadedScene scene) {
  const auto box = std::make_shared<LoadedScene>(std::move(scene));
  return queue_.call([this, box] { return change_now(box.get()); }, kDeadline);
}

Reply Simulation::scene(SceneSpec* spec) {
  return queue_.call(
      [this, spec] {
        *spec = scene_.spec;
        return Reply();
      },
      kDeadline);
}

Reply Simulation::fork(Fork* fork) {
  return queue_.call(
      [this, fork] {
        fork->spec = scene_.spec;
        fork->running_dt = scene_.running_dt;
        fork->world = scene_.world->copy();
        fork->script = scene_.script;
        fork->time = scene_.world->time();
        fork->stamp = pacer_.stamp(fork->time);
        return Reply();
      },
      kDeadline);
}

Reply Simulation::follow(TrajectoryGoal goal, std::shared_ptr<TrajectoryRun> run) {
  return queue_.call(
      [this, goal = std::move(goal), run = std::move(run)] {
        try {
          for (const GraspTrajectory& trajectory : goal.trajectories)
            for (const auto& other : trajectories_)
              if (other.first.moves(trajectory.grasp))
                return refused(Code::kUnavailable, "another trajectory moves '" + trajectory.grasp + "'");
          TrajectoryFollower follower(goal, *scene_.world);
          run->tell(follower.progress(), pacer_.stamp(scene_.world->time()));
          trajectories_.emplace_back(std::move(follower), run);
        } catch (const InputError& error) {
          return refused(error.code(), error.what());
        }
        return Reply();
      },
      kDeadline);
}

Reply Simulation::stop_following(const std::shared_ptr<TrajectoryRun>& run, const Status& why) {
  return queue_.call(
      [this, run, why] {
        for (auto& [follower, its_run] : trajectories_)
          if (its_run == run) follower.stop(why, scene_.world.get());
        follow_trajectories();
        return Reply();
      },
      kDeadline);
}

Reply Simulation::save(SavedState* state) {
  return queue_.call(
      [this, state] {
        state->scene = scene_.spec.file.empty() ? "(text)" : scene_.spec.file;
        state->time = scene_.world->time();
        state->script = scene_.script.taken();
        state->world = scene_.world->save();
        recorder_->saved(scene_.world->step_count(), pacer_.stamp(scene_.world->time()));
        state->frames = follower_.save();
        return Reply();
      },
      kDeadline);
}

Reply Simulation::restore(SavedState state) {
  const auto box = std::make_shared<SavedState>(std::move(state));
  return queue_.call(
      [this, box] {
        try {
          Script script = scene_.script;
          script.go_on_after(box->script);
          auto followers = follower_.read(box->frames, scene_.attached);
          scene_.world->restore(box->world);
          scene_.script = std::move(script);
          follower_.go_on_with(std::move(followers));
        } catch (const InputError& error) {
          return refused(error.code(), box->scene + ": " + error.what());
        }
        end_steps({Code::kUnavailable, "another state was restored"});
        end_trajectories({Code::kUnavailable, "another state was restored"}, nullptr);
        begin_time();
        begin_record();
        return Reply();
      },
      kDeadline);
}

Simulation::StepAnswer Simulation::step(std::uint32_t steps) {
  const auto run = std::make_shared<StepRun>();
  run->wanted = steps;
  const Reply reply = queue_.call([this, run] { return start_steps(run); }, kDeadline);
  if (!reply.status.ok()) {
    StepAnswer answer;
    answer.status = reply.status;
    return answer;
  }
  std::unique_lock<std::mutex> lock(run->mutex);
  run->finished.wait(lock, [&] { return run->done; });
  return run->answer;
}

Reply Simulation::describe(std::string* text) {
  return queue_.call(
      [this, text] {
        *text = description();
        return Reply();
      },
      kDeadline);
}

Reply Simulation::snapshot(Snapshot* snapshot, ros::Time* stamp) {
  return queue_.call(
      [this, snapshot, stamp] {
        *snapshot = scene_.world->snapshot();
        *stamp = pacer_.stamp(snapshot->time);
        return Reply();
      },
      kDeadline);
}

std::shared_ptr<const Model> Simulation::model() const {
  const std::lock_guard<std::mutex> lock(model_mutex_);
  return model_;
}

double Simulation::dt() const {
  const std::lock_guard<std::mutex> lock(model_mutex_);
  return dt_;
}

// The simulation thread from here on.

void Simulation::run() {
  const std::string refusal = take_real_time_priority(parameters_.priority);
  if (!refusal.empty()) {
    ROS_WARN_STREAM_NAMED("simulation", refusal);
    warnings_->set("priority", refusal);
  }
  // roscpp shuts down under a service that still waits, and waits for it in turn: answer it.
  while (!stopping_ && !ros::isShuttingDown()) {
    queue_.run();
    if (recorder_->has_newcomer()) begin_record();
    if (wants_to_step()) {
      const double wait = steps_ ? 0.0 : pacer_.seconds_until_due(scene_.world->time());
      if (wait > 0.0) {
        queue_.wait(wait);
      } else {
        advance();
      }
      continue;
    }
    speed_.pause();
    const bool unshown =
        outputs_.offer(*scene_.world, version_, Outputs::Motion::kIdle, [this] { return run_state(); });
    queue_.wait(unshown ? kUnshownWait : kIdleWait);
  }
  queue_.close();
  end_steps({Code::kUnavailable, "the node is shutting down"});
  end_trajectories({Code::kUnavailable, "the node is shutting down"}, nullptr);
}

bool Simulation::wants_to_step() const {
  if (!failure_.empty()) return false;
  return steps_ || (!paused_ && parameters_.clock != ClockMode::kOnDemand);
}

void Simulation::advance() {
  const auto began = SpeedMeter::Clock::now();
  play_script();
  follower_.update(scene_.world.get());
  for (auto& [follower, run] : trajectories_) follower.before_step(scene_.world.get());
  StepOutcome outcome;
  try {
    outcome = scene_.world->step();
  } catch (const std::exception& error) {
    outcome.ok = false;
    outcome.message = error.what();
  }
  ++version_;
  if (!outcome.ok) {
    failure_ = outcome.message.empty() ? "no finite state" : outcome.message;
    warnings_->set("failure", "stopped on the last good state: " + failure_);
    ROS_ERROR_STREAM_NAMED("simulation", "stopped on the last good state at "
                                             << scene_.world->time() << " s: " << failure_
                                             << "; ~reset, ~restore_state or ~load_scene recovers");
    end_steps({Code::kInternal, failure_});
    end_trajectories({Code::kInternal, failure_}, scene_.world.get());
    return;
  }
  for (auto& [follower, run] : trajectories_) follower.after_step(scene_.world.get());
  follow_trajectories();
  recorder_->stepped(scene_.world->step_count(), pacer_.stamp(scene_.world->time()));
  watch_speed(seconds_since(began), began);
  if (time_changed_) time_changed_(scene_.world->time());
  if (steps_ && ++steps_->answer.steps >= steps_->wanted) end_steps(Status());
  outputs_.offer(*scene_.world, version_, Outputs::Motion::kRunning, [this] { return run_state(); });
}

void Simulation::play_script() {
  while (const ScriptEvent* event = scene_.script.take(scene_.world->time())) {
    const Reply reply = apply_now(event->command);
    const std::string what = reply.status.ok() ? reply.note : reply.status.message;
    if (what.empty()) continue;
    const std::string text = said_of(*event, what);
    warnings_->set("script", text);
    ROS_WARN_STREAM_NAMED("simulation", text);
  }
}

/// Tells how trajectories go, and forgets those that are over.
void Simulation::follow_trajectories() {
  for (auto& [follower, run] : trajectories_) run->tell(follower.progress(), pacer_.stamp(scene_.world->time()));
  trajectories_.erase(std::remove_if(trajectories_.begin(), trajectories_.end(),
                                     [](const auto& entry) { return entry.first.progress().is_over; }),
                      trajectories_.end());
}

void Simulation::end_trajectories(const Status& why, World* world) {
  for (auto& [follower, run] : trajectories_) follower.stop(why, world);
  follow_trajectories();
}

void Simulation::watch_speed(double cost, SpeedMeter::Clock::time_point began) {
  if (!speed_.step(scene_.world->settings().dt, began, cost)) return;
  const double lost = pacer_.given_up() - given_up_before_;
  given_up_before_ = pacer_.given_up();
  behind_ = parameters_.clock == ClockMode::kRealTime && lost > kToleratedLoss;
  if (!behind_) {
    warnings_->clear("behind");
    if (gives_way_ && budget_ < kBudgetWhenLate) hold_budget(kBudgetRegained * budget_);
    return;
  }
  std::ostringstream text;
  text.precision(2);
  text << "real time is not held: factor " << std::fixed << speed_.factor() << ", a step of "
       << scene_.world->settings().dt * 1e3 << " ms takes " << speed_.mean_step_seconds() * 1e3 << " ms (longest "
       << speed_.longest_step_seconds() * 1e3 << " ms)";
  give_way(&text);
  warnings_->set("behind", text.str());
  ROS_WARN_STREAM_THROTTLE_NAMED(10.0, "real_time", text.str());
}

/// Real time is not held: what ~when_late says, and a word of it.
void Simulation::give_way(std::ostream* text) {
  if (parameters_.when_late == LatePolicy::kStop) {
    paused_ = true;
    speed_.pause();
    *text << "; paused, as when_late says: ~pause goes on";
  } else if (parameters_.when_late == LatePolicy::kLessAccurate) {
    // Others may take the rest of the core: what is measured to be too much is less than kBudgetWhenLate then.
    hold_budget(gives_way_ ? std::clamp(speed_.factor(), kLeastPart, 1.0) * budget_ : kBudgetWhenLate);
    gives_way_ = true;
    *text << "; accuracy gives way, up to an error of " << 100.0 * parameters_.accuracy_floor
          << " % a second, for a budget of " << budget_ << " CPU s per simulated s, then time";
  }
}

void Simulation::hold_budget(double budget) {
  budget_ = std::clamp(budget, kLeastBudget, kBudgetWhenLate);
  StepControlSettings control;
  control.control = StepControl::kBudget;
  control.error = std::min(scene_.spec.step.error, parameters_.accuracy_floor);
  control.budget = budget_;
  control.floor = parameters_.accuracy_floor;
  scene_.world->set_control(control);
  recorder_->depends("~when_late: less_accurate", scene_.world->step_count(), pacer_.stamp(scene_.world->time()));
}

Reply Simulation::all_now(const std::vector<Command>& commands) {
  Reply all;
  for (const Command& command : commands) {
    Reply reply = apply_now(command);
    if (!reply.status.ok()) return reply;
    if (all.nodes.empty()) all.nodes = std::move(reply.nodes);
    if (!reply.note.empty()) all.note += (all.note.empty() ? "" : "; ") + reply.note;
  }
  return all;
}

Reply Simulation::apply_now(const Command& command) {
  std::string moved;
  if (const auto* move = std::get_if<command::MoveGrasp>(&command)) moved = move->name;
  if (const auto* move = std::get_if<command::MoveCollider>(&command)) moved = move->name;
  const std::string frame = moved.empty() ? "" : follower_.frame_of(moved);
  for (const auto& entry : trajectories_) {
    if (!entry.first.moves(moved)) continue;
    return refused(Code::kUnavailable, "'" + moved + "' is moved along a trajectory; cancel ~follow_trajectory first");
  }
  if (!frame.empty()) {
    return refused(Code::kInvalidArgument, "'" + moved + "' follows tf frame " + frame + " and takes no targets");
  }
  const Reply reply = scene_.world->apply(command);
  if (!reply.status.ok()) return reply;
  ++version_;
  follower_.applied(command);
  if (std::holds_alternative<command::Grasp>(command) || std::holds_alternative<command::Release>(command) ||
      std::holds_alternative<command::RemoveCollider>(command))
    note_names();
  if (std::holds_alternative<command::Reset>(command)) begin_world();
  return reply;
}

Reply Simulation::attach_now(const Collider& collider, const Pose& frame_from_collider) {
  command::AddCollider add{collider};
  add.collider.frame_from_collider = frame_from_collider;
  const Reply reply = scene_.world->apply(add);
  if (!reply.status.ok()) return reply;
  ++version_;
  follower_.attach(collider, frame_from_collider);
  note_names();
  return reply;
}

Reply Simulation::start_steps(const std::shared_ptr<StepRun>& run) {
  if (!failure_.empty()) {
    return refused(Code::kUnavailable,
                   "the simulation failed (" + failure_ + "); ~reset, ~restore_state or ~load_scene first");
  }
  if (!paused_ && parameters_.clock != ClockMode::kOnDemand) {
    return refused(Code::kUnavailable, "time runs by itself; ~pause first, or start the node with clock: on_demand");
  }
  if (steps_) return refused(Code::kUnavailable, "another ~step is being made");
  steps_ = run;
  return Reply();
}

void Simulation::end_steps(const Status& status) {
  if (!steps_) return;
  const std::shared_ptr<StepRun> run = std::exchange(steps_, nullptr);
  const std::lock_guard<std::mutex> lock(run->mutex);
  run->answer.time = scene_.world->time();
  run->answer.status = status;
  run->done = true;
  run->finished.notify_all();
}

/// The old world is left in `scene`, to be destroyed by whoever asked.
Reply Simulation::change_now(LoadedScene* scene) {
  if (!failure_.empty()) {
    return refused(Code::kUnavailable,
                   "the simulation failed (" + failure_ + "); ~reset, ~restore_state or ~load_scene first");
  }
  try {
    if (scene->world) scene->world->continue_from(*scene_.world);
  } catch (const InputError& error) {
    return refused(error.code(), error.what());
  }
  scene->script.go_on_like(scene_.script);
  if (!scene->world) {
    std::swap(scene->world, scene_.world);
    scene->running_dt = scene_.running_dt;
  }
  std::swap(scene_, *scene);
  show_model();
  follower_.keep(scene_.world->grasp_reports());
  ++version_;
  note_names();
  begin_record();
  return Reply();
}

/// After a scene was loaded or reset: simulated time is 0 again.
void Simulation::begin_world() {
  show_model();
  scene_.script.restart();
  follower_.begin(scene_.attached, scene_.world->grasp_reports());
  begin_time();
  begin_record();
}

/// Whoever asks sees the world there is now, on its topics too.
void Simulation::show_model() {
  {
    const std::lock_guard<std::mutex> lock(model_mutex_);
    model_ = scene_.world->shared_model();
    dt_ = scene_.world->settings().dt;
  }
  scene_.world->watch([this](const Command& command) {
    recorder_->applied(command, scene_.world->step_count(), pacer_.stamp(scene_.world->time()));
  });
  outputs_.use(scene_.publishers);
}

/// Whoever records hears of another world, or of the same one gone elsewhere.
void Simulation::begin_record() {
  recorder_->begin(scene_.spec, scene_.running_dt, pacer_.stamp(scene_.world->time()), scene_.world.get());
}

/// Simulated time has jumped to that of the world.
void Simulation::begin_time() {
  if (pacer_.stamp(0.0).isZero()) frames_->forget();
  failure_.clear();
  gives_way_ = false;
  warnings_->clear("behind");
  warnings_->clear("failure");
  warnings_->clear("script");
  pacer_.restart(scene_.world->time());
  speed_.pause();
  ++version_;
  note_names();
  if (time_changed_) time_changed_(scene_.world->time());
}

void Simulation::note_names() {
  TopicNames names;
  for (const GraspReport& grasp : scene_.world->grasp_reports()) names.grasps.push_back(grasp.name);
  names.attached_colliders = follower_.colliders();
  names_changed_(names, scene_.publishers);
}

Instant Simulation::run_state() const {
  Instant instant;
  instant.stamp = pacer_.stamp(scene_.world->time());
  instant.paused = paused_ || !failure_.empty();
  instant.failure = failure_;
  instant.behind = behind_;
  instant.real_time_factor = speed_.factor();
  instant.mean_step_seconds = speed_.mean_step_seconds();
  instant.longest_step_seconds = speed_.longest_step_seconds();
  instant.warnings = warnings_->list();
  return instant;
}

std::string Simulation::description() const {
  const World& world = *scene_.world;
  std::ostringstream text;
  text << "scene: " << (scene_.spec.file.empty() ? "(text)" : scene_.spec.file);
  if (!scene_.spec.title.empty()) text << "\ntitle: " << scene_.spec.title;
  text << "\nclock: " << to_string(parameters_.clock) << "\ntime: " << world.time()
       << " s\nsteps: " << world.step_count() << "\nstep: " << world.settings().dt << " s, "
       << world.settings().integrator << "\nthreads: " << world.settings().threads
       << "\nsolver: " << (world.settings().chosen.empty() ? "as the scene says" : world.settings().chosen)
       << "\nstate: "
       << (!failure_.empty() ? "failed: " + failure_
           : wants_to_step() ? "running"
                             : "paused")
       << "\nreal-time factor: " << speed_.factor() << "\nsnapshots: " << outputs_.snapshot_count();
  for (const Body& body : world.model().bodies) {
    text << "\nbody: " << body.name << " (" << name_of(body.kind) << ", " << body.node_count << " nodes";
    if (body.skin) text << ", shown by " << body.skin->vertex_count() << " points";
    text << ")";
  }
  const Snapshot now = world.snapshot();
  for (const GraspReport& grasp : now.grasps) {
    text << "\ngrasp: " << grasp.name << " (" << grasp.body << ", " << grasp.nodes.size() << " nodes"
         << (grasp.follow_frame.empty() ? "" : ", follows " + grasp.follow_frame) << ")";
  }
  for (const Collider& collider : now.colliders) {
    text << "\nobstacle: " << collider.name << " (" << collider.shapes.size() << " shapes, at "
         << collider.world_from_collider.translation().transpose() << ")";
  }
  for (const CameraParameters& camera : parameters_.cameras) {
    text << "\ncamera: " << camera.name << " (" << camera.pinhole.width << " x " << camera.pinhole.height << ", at "
         << camera.frame << ", " << camera.rate << " Hz" << (camera.noise.any() ? ", with noise" : "") << ")";
  }
  for (const BillItem& item : world.bill()) {
    text << "\nbill: " << item.part << ", " << item.detail << ", " << 100.0 * item.share << " % of the step";
  }
  return text.str();
}

}  // namespace deformable_sim
