#include "deformable_sim/ros/pacer.h"

#include <algorithm>

namespace deformable_sim {

namespace {

constexpr double kMostBacklog = 0.1;  // s
constexpr double kWindow = 1.0;       // s
constexpr double kLongestWait = 0.1;  // s
constexpr double kClockPoll = 0.001;  // s

ros::Duration seconds(double s) {
  return ros::Duration().fromSec(s);
}

}  // namespace

Pacer::Pacer(ClockMode mode, bool publishes_clock) : mode_(mode), publishes_clock_(publishes_clock) {}

ros::Time Pacer::now() const {
  if (!publishes_clock_) return ros::Time::now();
  const ros::WallTime wall = ros::WallTime::now();
  return ros::Time(wall.sec, wall.nsec);
}

void Pacer::restart(double t) {
  if (mode_ != ClockMode::kRealTime) return;
  last_now_ = now();
  // A clock that nobody has published yet stands at zero; a negative epoch cannot be written.
  epoch_ = last_now_ > ros::Time(0) + seconds(t) ? last_now_ - seconds(t) : ros::Time(0);
}

double Pacer::seconds_until_due(double t) {
  if (mode_ != ClockMode::kRealTime) return 0.0;
  const ros::Time time = now();
  if (time < last_now_) restart(t);  // it jumped back: a bag loops, or somebody set the clock
  last_now_ = time;
  const double wait = (epoch_ + seconds(t) - time).toSec();
  if (wait < -kMostBacklog) {
    const double excess = -wait - kMostBacklog;
    epoch_ += seconds(excess);
    given_up_ += excess;
  }
  const bool external = ros::Time::isSimTime() && !publishes_clock_;
  return external && wait > 0.0 ? kClockPoll : std::min(wait, kLongestWait);
}

ros::Time Pacer::stamp(double t) const {
  const bool anchored = mode_ == ClockMode::kRealTime && !publishes_clock_;
  return anchored ? epoch_ + seconds(t) : ros::Time().fromSec(t);
}

void SpeedMeter::pause() {
  if (!running_) return;
  ran_ += std::chrono::duration<double>(Clock::now() - running_since_).count();
  running_ = false;
}

bool SpeedMeter::step(double dt, Clock::time_point began, double cost) {
  if (!running_) running_since_ = began;
  running_ = true;
  simulated_ += dt;
  busy_ += cost;
  slowest_ = std::max(slowest_, cost);
  ++steps_;
  const Clock::time_point now = Clock::now();
  const double ran = ran_ + std::chrono::duration<double>(now - running_since_).count();
  if (ran < kWindow) return false;
  factor_ = simulated_ / ran;
  mean_ = busy_ / steps_;
  longest_ = slowest_;
  running_since_ = now;
  ran_ = simulated_ = busy_ = slowest_ = 0.0;
  steps_ = 0;
  return true;
}

}  // namespace deformable_sim
