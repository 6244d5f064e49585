// A recorded session, made again.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "deformable_sim/core/world.h"
#include "recording.h"

namespace deformable_sim {

struct ReplayResult {
  int sessions = 0, commands = 0;
  std::uint64_t steps = 0;
  int equal = 0;      // recorded states that came again, to the last bit
  int different = 0;  // that did not
  int uncovered = 0;  // from before the first beginning, after the last record, or from steps that do not repeat
  std::string first_difference;
  std::string depends;  // why steps do not repeat, and from where on; empty: they do
  std::string machine;  // that recorded, where it is another
};

class Replay {
 public:
  /// `recording` must live on.
  Replay(const Recording& recording, int threads) : recording_(recording), threads_(threads) {}

  /// progress(share). Throws InputError: a scene that is refused, or cannot be restored.
  ReplayResult run(const std::function<void(double)>& progress);

 private:
  enum class Found { kNotYet, kDifferent, kEqual };
  struct Seen {
    Found found = Found::kNotYet;
    std::string difference;
  };

  void begin(const msg::SessionRecord& record);
  void step_to(std::uint64_t step);
  void apply(const msg::SessionRecord& record);
  void compare(ros::Time stamp);
  std::string difference(const RecordedState& state, ros::Time stamp) const;
  void conclude();

  const Recording& recording_;
  const int threads_;
  std::unique_ptr<World> world_;
  bool repeats_ = true;
  std::map<const RecordedState*, Seen> seen_;
  ReplayResult result_;
};

}  // namespace deformable_sim
