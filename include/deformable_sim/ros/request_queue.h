// Jobs from callbacks to the simulation thread, done between steps in arrival order.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "deformable_sim/core/command.h"

namespace deformable_sim {

/// Runs on the simulation thread; answers with a Reply.
using Job = std::function<Reply()>;
/// Told the reply of a posted job, on the simulation thread.
using Done = std::function<void(const Reply&)>;

class RequestQueue {
 public:
  /// Waits for the reply. After `deadline` s (wall) the job is taken back and the answer is kTimeout: it is then never
  /// done.
  Reply call(Job job, double deadline);
  /// Does not wait. `done` hears kUnavailable at once, on the caller's thread, when the queue is full or closed.
  void post(Job job, Done done);
  /// Answers everything waiting and everything to come with kUnavailable.
  void close();

  /// Simulation thread: does what had arrived on entry. Returns whether there was anything.
  bool run();
  /// Simulation thread: waits until something arrives, at most `seconds`.
  void wait(double seconds);

 private:
  enum class Phase { kWaiting, kRunning, kDone };
  struct Request {
    Job job;
    Done done;
    Phase phase = Phase::kWaiting;
    Reply reply;
  };

  bool push(const std::shared_ptr<Request>& request);  // mutex_ held
  static Reply refusal(bool closed);

  std::mutex mutex_;
  std::condition_variable arrived_, finished_;
  std::deque<std::shared_ptr<Request>> waiting_;
  bool closed_ = false;
};

}  // namespace deformable_sim
