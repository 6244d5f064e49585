#include "deformable_sim/ros/warnings.h"

namespace deformable_sim {

namespace {

constexpr auto kShown = std::chrono::seconds(10);
constexpr std::size_t kMostEvents = 20;

}  // namespace

void Warnings::set(const std::string& key, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  conditions_[key] = text;
}

void Warnings::clear(const std::string& key) {
  const std::lock_guard<std::mutex> lock(mutex_);
  conditions_.erase(key);
}

void Warnings::event(const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  events_.emplace_back(Clock::now(), text);
  if (events_.size() > kMostEvents) events_.pop_front();
}

std::vector<std::string> Warnings::list() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<std::string> texts;
  for (const auto& [key, text] : conditions_) texts.push_back(text);
  const auto oldest = Clock::now() - kShown;
  for (const auto& [when, text] : events_) {
    if (when > oldest) texts.push_back(text);
  }
  return texts;
}

}  // namespace deformable_sim
