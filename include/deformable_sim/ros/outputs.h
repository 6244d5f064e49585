// From the world to the topics: what is due, a snapshot of it, and a thread that turns it into messages.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "deformable_sim/core/world.h"
#include "deformable_sim/ros/parameters.h"
#include "deformable_sim/ros/publishers/publisher.h"

namespace deformable_sim {

/// The publishers of one scene with their periods.
struct PublisherSet {
  struct Entry {
    std::unique_ptr<Publisher> publisher;
    double period = 0.0;  // s; 0 = never
    bool repeats = false;
  };
  std::vector<Entry> entries;
};

/// Advertises the topics of a scene (network). Rates given as parameters replace the scene's.
std::shared_ptr<PublisherSet> make_publishers(const PublisherContext& context, const Parameters& parameters);

/// offer() belongs to the simulation thread and never waits for a subscriber: messages are built and sent by a thread
/// of this object, which takes the newest state when it is ready and skips what it had no time for.
class Outputs {
 public:
  Outputs();
  ~Outputs();

  /// Simulation thread: publishers of the scene shown from now on.
  void use(std::shared_ptr<PublisherSet> publishers);

  enum class Motion { kRunning, kIdle };
  /// Simulation thread: shows the world to the topics that have a subscriber and are due: by simulated time while
  /// running; when idle whatever changed since, and everything to newcomers. `run` is completed by a snapshot if any is
  /// due. `version` changes whenever the world or its run does. Returns whether something remains to be shown later.
  bool offer(const World& world, std::uint64_t version, Motion motion, const std::function<Instant()>& run);

  /// Snapshots taken for topics so far.
  std::uint64_t snapshot_count() const { return snapshots_; }

 private:
  using Clock = std::chrono::steady_clock;

  struct Due {
    double next = 0.0;          // s, simulated
    std::uint64_t version = 0;  // shown last
    unsigned joined = 0;        // subscribers that had come by then
    Clock::time_point shown;
  };
  struct Letter {
    std::shared_ptr<PublisherSet> publishers;
    std::shared_ptr<const Instant> instant;
    std::vector<bool> due;
  };

  bool is_due(const PublisherSet::Entry& entry, const Due& due, double time, double dt, std::uint64_t version,
              Motion motion, bool* later) const;
  template <class Asks>
  bool any_due(const Asks& asks);
  void send(Letter letter);
  void publish_loop();

  std::shared_ptr<PublisherSet> publishers_;
  std::vector<Due> due_;
  std::vector<bool> now_;
  std::atomic<std::uint64_t> snapshots_{0};

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::unique_ptr<Letter> letter_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace deformable_sim
