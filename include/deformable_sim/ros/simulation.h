// The thread that owns the world: requests, pacing, steps, outputs.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <ostream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "deformable_sim/core/world.h"
#include "deformable_sim/ros/frame_follower.h"
#include "deformable_sim/ros/outputs.h"
#include "deformable_sim/ros/pacer.h"
#include "deformable_sim/ros/parameters.h"
#include "deformable_sim/ros/request_queue.h"
#include "deformable_sim/ros/session_recorder.h"
#include "deformable_sim/ros/warnings.h"
#include "deformable_sim/scene/script.h"
#include "deformable_sim/scene/state_file.h"
#include "deformable_sim/scene/trajectory_follower.h"

namespace deformable_sim {

/// A scene, built and ready to run.
struct LoadedScene {
  SceneSpec spec;
  std::unique_ptr<World> world;
  std::optional<double> running_dt;  // the world was built to go on with this dt
  std::vector<Collider> attached;    // moved by tf, relative to their frames; not in the world yet
  Script script;
  std::shared_ptr<PublisherSet> publishers;
};

/// A copy of a running simulation, to be built.
struct Fork {
  SceneSpec spec;
  std::optional<double> running_dt;  // as LoadedScene
  std::string world;                 // World::copy()
  Script script;
  double time = 0.0;  // s
  ros::Time stamp;    // of that time
};

/// A trajectory somebody waits for.
class TrajectoryRun {
 public:
  void tell(const TrajectoryProgress& progress, ros::Time stamp);
  /// What was told last. Waits until it is over, at most `seconds` (wall).
  TrajectoryProgress wait(double seconds, ros::Time* stamp);

 private:
  std::mutex mutex_;
  std::condition_variable over_;
  TrajectoryProgress progress_;
  ros::Time stamp_;
};

/// All public functions may be called from any thread; they wait for the simulation thread unless they say otherwise.
class Simulation {
 public:
  /// Told on the simulation thread which grasps and attached colliders there are, whenever that changed.
  using NamesChanged = std::function<void(const TopicNames& names, std::shared_ptr<PublisherSet>)>;
  /// Told after each step and reset: simulated time, s. Empty when there is no /clock to publish.
  using TimeChanged = std::function<void(double time)>;

  struct StepAnswer {
    double time = 0.0;  // s, reached
    std::uint32_t steps = 0;
    Status status;
  };

  Simulation(const Parameters& parameters, Frames* frames, Warnings* warnings, SessionRecorder* recorder);
  ~Simulation();

  void start(LoadedScene scene, NamesChanged names_changed, TimeChanged time_changed);
  /// Ends the thread; whoever waits is answered.
  void stop();

  /// Applied together, in order, up to the first refusal.
  Reply apply(std::vector<Command> commands);
  /// A collider that moves with its frame.
  Reply attach(const Collider& collider, const Pose& frame_from_collider);
  /// Does not wait; `done` hears the reply on the simulation thread.
  void post(std::vector<Command> commands, Done done);
  void post_attach(const Collider& collider, const Pose& frame_from_collider, Done done);

  Reply pause(bool paused);
  Reply reset();
  Reply replace(LoadedScene scene);
  /// The scene with changes, as SceneLoader::changed() built it, in place of the running one: time goes on, and what
  /// both have stays as it is. Without a world the bodies stay too, and only what is shown changes. Refused, it changes
  /// nothing.
  Reply change(LoadedScene scene);
  /// What the running scene was made of.
  Reply scene(SceneSpec* spec);
  /// All that a copy of the running world is made of; it goes on as if nobody had asked.
  Reply fork(Fork* fork);
  /// Moves grasps from the next step on; `run` tells how it goes. A grasp moved so takes no other targets.
  Reply follow(TrajectoryGoal goal, std::shared_ptr<TrajectoryRun> run);
  /// Grasps stop where they are.
  Reply stop_following(const std::shared_ptr<TrajectoryRun>& run, const Status& why);
  Reply save(SavedState* state);
  /// Refused, it changes nothing.
  Reply restore(SavedState state);
  /// Runs `steps` steps and returns when they are done. Refused while time runs by itself.
  StepAnswer step(std::uint32_t steps);
  Reply describe(std::string* text);
  Reply snapshot(Snapshot* snapshot, ros::Time* stamp);
  /// The model now running; changes with replace(). Does not wait.
  std::shared_ptr<const Model> model() const;
  double dt() const;

 private:
  struct StepRun;

  void run();
  void advance();
  void play_script();
  void follow_trajectories();
  void end_trajectories(const Status& why, World* world);
  bool wants_to_step() const;
  Reply apply_now(const Command& command);
  Reply attach_now(const Collider& collider, const Pose& frame_from_collider);
  Reply all_now(const std::vector<Command>& commands);
  Reply start_steps(const std::shared_ptr<StepRun>& run);
  Reply change_now(LoadedScene* scene);
  void begin_world();
  void show_model();
  void begin_time();
  void begin_record();
  void note_names();
  void end_steps(const Status& status);
  void watch_speed(double cost, SpeedMeter::Clock::time_point began);
  void give_way(std::ostream* text);
  void hold_budget(double budget);
  std::string description() const;
  Instant run_state() const;

  const Parameters parameters_;
  Frames* frames_;
  Warnings* warnings_;
  SessionRecorder* recorder_;
  RequestQueue queue_;
  Pacer pacer_;
  SpeedMeter speed_;
  FrameFollower follower_;
  Outputs outputs_;
  NamesChanged names_changed_;
  TimeChanged time_changed_;

  // Of the simulation thread.
  LoadedScene scene_;
  bool paused_;
  std::string failure_;
  bool behind_ = false;
  bool gives_way_ = false;  // accuracy does, since the world was begun
  double budget_ = 0.0;     // CPU s per simulated s; then
  double given_up_before_ = 0.0;
  std::uint64_t version_ = 0;
  std::shared_ptr<StepRun> steps_;
  std::vector<std::pair<TrajectoryFollower, std::shared_ptr<TrajectoryRun>>> trajectories_;

  mutable std::mutex model_mutex_;
  std::shared_ptr<const Model> model_;
  double dt_ = 0.0;

  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace deformable_sim
