// Topics of things that come and go, one each.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deformable_sim/ros/publishers/publisher.h"

namespace deformable_sim {

/// Asked on any thread; update() on the thread that keeps topics.
class NamedTopics {
 public:
  bool wanted() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::any_of(topics_.begin(), topics_.end(), [](const auto& entry) { return entry.second.wanted(); });
  }
  unsigned joined() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    unsigned sum = left_;
    for (const auto& [name, topic] : topics_) sum += topic.joined();
    return sum;
  }

  /// topic_of(name): the topic's name.
  template <typename Message, typename TopicOf>
  void update(const PublisherContext& context, const std::vector<std::string>& names, const TopicOf& topic_of) {
    std::map<std::string, Topic> next;
    for (const std::string& name : names) {
      const auto known = topics_.find(name);  // only this thread changes the map
      next[name] = known != topics_.end() ? known->second : Topic::advertise<Message>(context, topic_of(name));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    topics_.swap(next);
    for (const auto& [name, topic] : next) {
      if (topics_.count(name) == 0) left_ += topic.joined();  // joined() only grows
    }
  }

  /// Nothing when nobody listens.
  std::optional<Topic> find_wanted(const std::string& name) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = topics_.find(name);
    if (found == topics_.end() || !found->second.wanted()) return std::nullopt;
    return found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, Topic> topics_;
  unsigned left_ = 0;
};

}  // namespace deformable_sim
