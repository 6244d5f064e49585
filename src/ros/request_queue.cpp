#include "deformable_sim/ros/request_queue.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace deformable_sim {

namespace {

constexpr std::size_t kMostWaiting = 1000;

std::chrono::steady_clock::time_point after(double seconds) {
  using std::chrono::steady_clock;
  return steady_clock::now() +
         std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

Reply RequestQueue::refusal(bool closed) {
  Reply reply;
  reply.status = {Code::kUnavailable, closed ? "the node is shutting down" : "too many requests are waiting"};
  return reply;
}

bool RequestQueue::push(const std::shared_ptr<Request>& request) {
  if (closed_ || waiting_.size() >= kMostWaiting) return false;
  waiting_.push_back(request);
  arrived_.notify_one();
  return true;
}

Reply RequestQueue::call(Job job, double deadline) {
  const auto request = std::make_shared<Request>();
  request->job = std::move(job);
  std::unique_lock<std::mutex> lock(mutex_);
  if (!push(request)) return refusal(closed_);
  const auto is_done = [&] { return request->phase == Phase::kDone; };
  if (finished_.wait_until(lock, after(deadline), is_done)) return request->reply;
  if (request->phase == Phase::kWaiting) {
    waiting_.erase(std::find(waiting_.begin(), waiting_.end(), request));
    Reply reply;
    reply.status = {Code::kTimeout, "the simulation did not get to it within " + std::to_string(deadline) +
                                        " s; it is not and will not be applied"};
    return reply;
  }
  finished_.wait(lock, is_done);  // being applied now: the answer must be what became of it
  return request->reply;
}

void RequestQueue::post(Job job, Done done) {
  const auto request = std::make_shared<Request>();
  request->job = std::move(job);
  request->done = std::move(done);
  std::unique_lock<std::mutex> lock(mutex_);
  if (push(request)) return;
  const Reply reply = refusal(closed_);
  lock.unlock();
  request->done(reply);
}

void RequestQueue::close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  for (const auto& request : waiting_) {
    request->reply = refusal(true);
    request->phase = Phase::kDone;
  }
  waiting_.clear();
  finished_.notify_all();
  arrived_.notify_all();
}

bool RequestQueue::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  // A flood of requests must not stop time, so those arriving meanwhile wait for the next step.
  const std::size_t count = waiting_.size();
  for (std::size_t i = 0; i < count && !waiting_.empty(); ++i) {
    const std::shared_ptr<Request> request = waiting_.front();
    waiting_.pop_front();
    request->phase = Phase::kRunning;
    lock.unlock();
    try {
      request->reply = request->job();
    } catch (const InputError& error) {
      request->reply.status = {error.code(), error.what()};
    } catch (const std::exception& error) {
      request->reply.status = {Code::kInternal, error.what()};
    }
    if (request->done) request->done(request->reply);
    lock.lock();
    request->phase = Phase::kDone;
    finished_.notify_all();
  }
  return count > 0;
}

void RequestQueue::wait(double seconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  arrived_.wait_until(lock, after(seconds), [&] { return closed_ || !waiting_.empty(); });
}

}  // namespace deformable_sim
