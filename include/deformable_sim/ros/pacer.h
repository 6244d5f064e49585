// When the next step is due, what stamp a state carries, how fast simulated time runs.
#pragma once

#include <chrono>

#include <ros/time.h>

#include "deformable_sim/ros/parameters.h"

namespace deformable_sim {

/// real_time: the state of simulated time t is due at ROS time epoch + t. A simulation that cannot keep up, or was held
/// up, does not sprint: what it is behind by more than 0.1 s is given up, the epoch moves forward by it, and the
/// real-time factor shows it. Stamps are epoch + t, so they stay ROS times that tf can be asked for.
/// Otherwise, and with an own /clock, a step is due at once (own /clock in real time: by wall time) and stamps are t.
/// One thread at a time.
class Pacer {
 public:
  Pacer(ClockMode mode, bool publishes_clock);

  /// Simulated time t is now: at start, after a pause, after time was set.
  void restart(double t);
  /// Wall s until the step that begins at t is due; <= 0: now.
  double seconds_until_due(double t);
  ros::Time stamp(double t) const;
  /// Simulated s given up so far because steps took too long.
  double given_up() const { return given_up_; }

 private:
  ros::Time now() const;

  ClockMode mode_;
  bool publishes_clock_;
  ros::Time epoch_;
  ros::Time last_now_;
  double given_up_ = 0.0;
};

/// Simulated s per wall s, and the cost of a step, over windows of one second of running.
class SpeedMeter {
 public:
  using Clock = std::chrono::steady_clock;

  /// The simulation stands still from now on, until the next step.
  void pause();
  /// A step of dt (s) took `cost` s, beginning at `began`. Returns whether a window closed: new values.
  bool step(double dt, Clock::time_point began, double cost);

  double factor() const { return factor_; }           // 0 until measured
  double mean_step_seconds() const { return mean_; }  // of the last window
  double longest_step_seconds() const { return longest_; }

 private:
  bool running_ = false;
  Clock::time_point running_since_;
  double ran_ = 0.0;  // s of this window before running_since_
  double simulated_ = 0.0, busy_ = 0.0, slowest_ = 0.0;
  int steps_ = 0;
  double factor_ = 0.0, mean_ = 0.0, longest_ = 0.0;
};

}  // namespace deformable_sim
