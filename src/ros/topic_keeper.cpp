#include "deformable_sim/ros/topic_keeper.h"

#include <chrono>
#include <utility>

#include "deformable_sim/ros/master_watch.h"

namespace deformable_sim {

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kWatchPeriod = std::chrono::seconds(2);

}  // namespace

TopicKeeper::TopicKeeper(std::vector<std::string> services)
    : services_(std::move(services)), thread_([this] { run(); }) {}

TopicKeeper::~TopicKeeper() {
  stop();
}

void TopicKeeper::post(std::function<void()> task) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    task_ = std::move(task);
  }
  arrived_.notify_one();
}

void TopicKeeper::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  arrived_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void TopicKeeper::run() {
  MasterWatch watch;
  auto next_check = Clock::now() + kWatchPeriod;
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stopping_) {
    arrived_.wait_until(lock, next_check, [this] { return stopping_ || task_; });
    if (stopping_) return;
    const std::function<void()> task = std::exchange(task_, nullptr);
    lock.unlock();
    if (task) task();
    // Grasps that come and go all the time leave no pause to wait for.
    if (Clock::now() >= next_check) {
      watch.check(services_);
      next_check = Clock::now() + kWatchPeriod;
    }
    lock.lock();
  }
}

}  // namespace deformable_sim
