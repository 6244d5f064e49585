// What happens by itself in a scene: grasps, releases and moves at given times.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "deformable_sim/scene/spec.h"

namespace deformable_sim {

/// Hands out the commands of a scene's `script` as their times come. Whoever steps the world applies them, between
/// steps, as those of any other source.
class Script {
 public:
  Script() = default;
  explicit Script(std::vector<ScriptEvent> events) : events_(std::move(events)) {}

  /// The next event whose time has come, each once and in order; nullptr when there is none.
  const ScriptEvent* take(double time) {
    // Times are multiples of a step only up to rounding, far less than the shortest step.
    constexpr double kRounding = 1e-12;
    if (next_ == events_.size() || events_[next_].time > time + kRounding * (1.0 + time)) return nullptr;
    return &events_[next_++];
  }
  /// From the beginning: the world was reset.
  void restart() { next_ = 0; }
  /// How many events were taken, and from there on. Throws InputError when there are not as many.
  std::size_t taken() const { return next_; }
  void go_on_after(std::size_t events);
  /// From where another has come to, of which this one has some of the events.
  void go_on_like(const Script& other);

 private:
  std::vector<ScriptEvent> events_;
  std::size_t next_ = 0;
};

/// Applies what is due. Returns the first refusal, its message led by the event's place in the file, and applies
/// nothing after it; else OK, with the notes of all.
Reply play(Script* script, World* world);

/// "file:line: key: at T s: what" of an event that was refused or is worth a note.
std::string said_of(const ScriptEvent& event, const std::string& what);

}  // namespace deformable_sim
