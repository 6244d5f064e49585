#include "deformable_sim/ros/saved_states.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "deformable_sim/core/error.h"
#include "deformable_sim/ros/convert.h"

namespace deformable_sim {

namespace {

constexpr std::size_t kMostNames = 64;
constexpr std::size_t kMostBytes = 1u << 30u;  // of all names together

void check_one(const std::string& name, const std::string& file) {
  if (name.empty() == file.empty()) throw InputError("name, file: one of the two must be given, the other empty");
  if (!name.empty()) check_name("name", name);
}

}  // namespace

/// Letters, digits, and . _ - in between: such a name lies in the folder, whatever the folder holds.
std::string SavedStates::path_of(const std::string& file) const {
  const auto plain = [](unsigned char c) { return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-'; };
  if (file.size() > 128 || file[0] == '.' || !std::all_of(file.begin(), file.end(), plain)) {
    throw InputError("file: '" + printable(file) +
                     "'; allowed is a name of letters, digits, '.', '_' and '-', of a file in " + folder_);
  }
  return folder_ + "/" + file;
}

void SavedStates::put(const std::string& name, const std::string& file, const SavedState& state) {
  check_one(name, file);
  if (!file.empty()) {
    write_state_file(path_of(file), state);
    return;
  }
  std::string bytes = state_bytes(state);
  const std::lock_guard<std::mutex> lock(mutex_);
  std::size_t others = 0;
  for (const auto& [other, kept] : by_name_) others += other == name ? 0 : kept.size();
  if ((by_name_.count(name) == 0 && by_name_.size() >= kMostNames) || others + bytes.size() > kMostBytes) {
    throw InputError("name: 64 states and 1 GiB are kept in memory at most; save to a file, or to a name in use",
                     Code::kOutOfRange);
  }
  by_name_[name] = std::move(bytes);
}

SavedState SavedStates::get(const std::string& name, const std::string& file) const {
  check_one(name, file);
  if (!file.empty()) return read_state_file(path_of(file));
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = by_name_.find(name);
  if (found != by_name_.end()) return read_state(found->second);
  std::string known;
  for (const auto& [other, bytes] : by_name_) known += (known.empty() ? "" : ", ") + other;
  throw InputError("name: '" + name + "' was not saved; there are " + (known.empty() ? "none" : known),
                   Code::kNotFound);
}

std::string default_state_dir() {
  if (const char* home = std::getenv("ROS_HOME"); home != nullptr && *home != '\0') {
    return std::string(home) + "/deformable_sim";
  }
  const char* home = std::getenv("HOME");
  return std::string(home == nullptr ? "" : home) + "/.ros/deformable_sim";
}

}  // namespace deformable_sim
