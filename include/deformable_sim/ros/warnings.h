// What a user should know now: conditions that last until cleared, and events that are shown for a while.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace deformable_sim {

/// Thread safe.
class Warnings {
 public:
  void set(const std::string& key, const std::string& text);
  void clear(const std::string& key);
  /// Shown for 10 s of wall time, the newest 20 only.
  void event(const std::string& text);
  std::vector<std::string> list() const;

 private:
  using Clock = std::chrono::steady_clock;

  mutable std::mutex mutex_;
  std::map<std::string, std::string> conditions_;
  std::deque<std::pair<Clock::time_point, std::string>> events_;
};

}  // namespace deformable_sim
