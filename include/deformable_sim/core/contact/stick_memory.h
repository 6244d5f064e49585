// What friction remembers from step to step, so that what sticks stays where it is.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "deformable_sim/core/archive.h"
#include "deformable_sim/core/types.h"

namespace deformable_sim {

/// ContactConstraint::stuck by contact from one step to the next, in coordinates of the finder's choice (those of the
/// collider, or of a pair's own frame). A step may be made in parts, and again from its start:
///
///   begin_step()            what is remembered now is what a repeated step starts with
///   rewind(), recall(key)   keys ascending; of the last part that was stored. As often as wanted
///   store(key, stuck) ...   keys ascending
///   end_part()              a part of the step is accepted: what was stored since the last one is remembered
///   restart()               the step begins again
///
/// Allocates nothing once lists have their size.
template <class Key>
class StickMemoryBy {
 public:
  void begin_step() {
    if (remembered_ == Remembered::kOfLastPart) std::swap(start_, last_);
    remembered_ = Remembered::kOfStart;
  }
  void restart() {
    remembered_ = Remembered::kOfStart;
    stored_.clear();
  }
  void forget() {
    start_.clear();
    restart();
  }

  void rewind() { next_ = 0; }
  /// m; zero for a contact that did not stick.
  Vec3 recall(const Key& key) {
    const std::vector<Entry>& list = remembered_ == Remembered::kOfStart ? start_ : last_;
    while (next_ < list.size() && list[next_].key < key) ++next_;
    return next_ < list.size() && list[next_].key == key ? list[next_].stuck : Vec3::Zero();
  }

  /// Between two steps. pass_key(&key) hands over a key.
  template <class PassKey>
  void pass(Archive* archive, const PassKey& pass_key) {
    begin_step();
    archive->pass_each(&start_, sizeof(Vec3), [&](Entry* entry) {
      pass_key(&entry->key);
      archive->pass(&entry->stuck);
    });
  }

  void store(const Key& key, const Vec3& stuck) {
    if (!stuck.isZero(0.0)) stored_.push_back({key, stuck});
  }
  void end_part() {
    std::swap(last_, stored_);
    stored_.clear();
    remembered_ = Remembered::kOfLastPart;
  }

 private:
  struct Entry {
    Key key{};
    Vec3 stuck = Vec3::Zero();
  };
  enum class Remembered { kOfStart, kOfLastPart };

  std::vector<Entry> start_, last_, stored_;
  Remembered remembered_ = Remembered::kOfStart;
  size_t next_ = 0;
};

using StickMemory = StickMemoryBy<std::int64_t>;

}  // namespace deformable_sim
