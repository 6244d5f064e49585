// The private parameters of the node: read once at start, typed, range-checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deformable_sim/ros/camera/camera_parameters.h"

namespace ros {
class NodeHandle;
}

namespace deformable_sim {

enum class ClockMode { kRealTime, kAsFastAsPossible, kOnDemand };
/// What gives way when real time cannot be held.
enum class LatePolicy { kSlowDown, kLessAccurate, kStop };

struct Parameters {
  std::string scene;                      // file, or bare name of a scene in scene_dir; required
  std::string scene_dir;                  // where bare names are looked up; absolute
  std::vector<std::string> allowed_dirs;  // further folders whose files requests may name
  std::string state_dir;                  // where saved states are written and read
  std::string frame_id = "world";         // tf frame of the simulation
  ClockMode clock = ClockMode::kRealTime;
  bool publish_clock = false;          // publish /clock, simulated time from 0
  std::optional<double> rate_markers;  // Hz, 0 ... 1000, 0 = never; unset = the scene's
  std::optional<double> rate_points;   // Hz
  std::optional<double> rate_state;    // Hz
  std::vector<CameraParameters> cameras;
  int threads = 1;   // for the physics, 1 ... 64
  int priority = 0;  // 0 ... 99, SCHED_FIFO, of the simulation's thread; 0: as all others
  LatePolicy when_late = LatePolicy::kSlowDown;
  double accuracy_floor = 0.1;  // 1e-5 ... 1, error over a second up to which kLessAccurate goes
  bool start_paused = false;
  double tf_timeout = 0.1;  // s, 0.001 ... 10
};

const char* to_string(ClockMode mode);
const char* to_string(LatePolicy policy);

/// Reads and checks all. Throws InputError naming the parameter and what is allowed. Unknown private parameters and
/// one summary line are logged.
Parameters read_parameters(const ros::NodeHandle& private_nh);

}  // namespace deformable_sim
