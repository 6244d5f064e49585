#include "deformable_sim/core/parallel/workers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <string>
#include <thread>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr int kPatience = 2000;  // looks for a piece in a row, some 50 us, before a core is offered to others
constexpr size_t kLine = 64;     // bytes that a core takes from memory at once

/// Cores of this process, unless the program has set another limit.
int most_at_once() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Spins, politely after a while.
template <class Condition>
void wait_until(const Condition& condition) {
  for (int looks = 0; !condition(); ++looks) looks < kPatience ? pause_briefly() : std::this_thread::yield();
}

}  // namespace

/// Outlives its Workers where a thread comes late.
struct Workers::Team {
  explicit Team(int threads) : arena(threads), count(threads) {}

  tbb::task_arena arena;
  int count;  // of threads, the caller's among them

  bool has_shared = false;
  bool in_shift = false;                      // the caller's
  std::atomic<bool> open{false};              // there is work in this shift
  std::atomic<int> called{0};                 // other threads that are there, or have been asked to come
  alignas(kLine) std::atomic<int> inside{0};  // those that may be looking at `loop`
  alignas(kLine) std::atomic<const Loop*> loop{nullptr};
  std::atomic<bool> busy{false};  // a loop is under way
  std::atomic<bool> failed{false};
  std::exception_ptr failure;

  /// Pieces are dealt out to the threads, each of which begins with its own: what it had in its cache in the last loop.
  struct alignas(kLine) Share {
    std::atomic<int> next{0};
    int end = 0;
  };
  std::array<Share, kMost> shares;

  void work(const Loop& now, int member) {
    try {
      for (int k = 0; k < count; ++k) {
        Share& share = shares[static_cast<size_t>((member + k) % count)];
        for (int piece; (piece = share.next++) < share.end;) now.piece(now.work, piece);
      }
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  }

  /// What another thread does from shift to shift, until there is none for a while.
  void attend(int member) {
    for (;;) {
      while (open) {
        wait_until([this] { return loop != nullptr || !open; });
        ++inside;
        if (const Loop* now = loop) work(*now, member);
        --inside;
      }
      for (int looks = 0; looks < kPatience && !open; ++looks) pause_briefly();
      if (open) continue;
      --called;
      if (!open) return;
      ++called;
    }
  }
};

Workers::Workers(int threads) : threads_(std::min(threads, most_at_once())) {
  if (threads < 1 || threads > kMost) throw InputError("threads must be 1 ... " + std::to_string(kMost));
  if (threads_ > 1) team_ = std::make_shared<Team>(threads_);
}

Workers::~Workers() = default;

bool Workers::have_shared() const {
  return team_ != nullptr && team_->has_shared;
}

void Workers::run(const Loop& loop) const {
  Team& team = *team_;
  if (team.busy.exchange(true)) {  // within a piece
    for (int k = 0; k < loop.pieces; ++k) loop.piece(loop.work, k);
    return;
  }
  team.has_shared = true;
  if (team.in_shift && !team.open) call_others();
  for (int k = 0; k < team.count; ++k) {
    Team::Share& share = team.shares[static_cast<size_t>(k)];
    share.next = loop.pieces * k / team.count;
    share.end = loop.pieces * (k + 1) / team.count;
  }
  team.loop = &loop;
  team.work(loop, 0);
  team.loop = nullptr;
  wait_until([&team] { return team.inside == 0; });
  team.busy = false;
  if (team.failed.exchange(false)) std::rethrow_exception(team.failure);
}

/// Numbers of members may be given twice: they only tell where to begin.
void Workers::call_others() const {
  team_->open = true;
  while (team_->called < team_->count - 1) {
    const int member = ++team_->called;
    team_->arena.enqueue([team = team_, member] { team->attend(member); });
  }
}

Workers::Shift::Shift(const Workers* workers) : workers_(workers) {
  if (workers_ != nullptr && workers_->team_ != nullptr) workers_->team_->in_shift = true;
}

Workers::Shift::~Shift() {
  if (workers_ == nullptr || workers_->team_ == nullptr) return;
  workers_->team_->in_shift = false;
  workers_->team_->open = false;
}

}  // namespace deformable_sim
