// Where ~save_state puts states and ~restore_state finds them.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "deformable_sim/scene/state_file.h"

namespace deformable_sim {

/// Either by name, in memory until the node ends, or by file name within one folder. Any thread.
class SavedStates {
 public:
  /// folder: of files; made when the first is written.
  explicit SavedStates(std::string folder) : folder_(std::move(folder)) {}

  /// Exactly one of `name` and `file` is given. Throws InputError: both or none, a name that is none, a file name that
  /// would lie elsewhere, too much in memory (kOutOfRange), a folder that cannot be written (kUnavailable).
  void put(const std::string& name, const std::string& file, const SavedState& state);
  /// Throws InputError, kNotFound with the names that there are.
  SavedState get(const std::string& name, const std::string& file) const;

 private:
  std::string path_of(const std::string& file) const;

  const std::string folder_;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> by_name_;  // bytes
};

/// $ROS_HOME/deformable_sim, or ~/.ros/deformable_sim.
std::string default_state_dir();

}  // namespace deformable_sim
