// The thread that talks to the master: topics of grasps come and go, and registrations outlive a master that was
// restarted.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace deformable_sim {

/// Talking to the master can take long (it may be gone), so neither the simulation nor the publishing thread does it.
class TopicKeeper {
 public:
  /// `services`: full names of the node's services.
  explicit TopicKeeper(std::vector<std::string> services);
  ~TopicKeeper();

  /// Does `task` soon, on the thread; one not begun yet is replaced.
  void post(std::function<void()> task);
  void stop();

 private:
  void run();

  const std::vector<std::string> services_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::function<void()> task_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace deformable_sim
