#include "deformable_sim/core/parallel/workers.h"

#include <algorithm>
#include <string>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

/// Cores of this process, unless the program has set another limit.
int most_at_once() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace

struct Workers::Arena {
  tbb::task_arena tbb;
};

Workers::Workers(int threads) : threads_(std::min(threads, most_at_once())) {
  if (threads < 1 || threads > kMost) throw InputError("threads must be 1 ... " + std::to_string(kMost));
  if (threads_ > 1) arena_ = std::unique_ptr<Arena>(new Arena{tbb::task_arena(threads_)});
}

Workers::~Workers() = default;

void Workers::run(int pieces, void (*piece)(const void*, int), const void* work) const {
  const auto loop = [&] {
    tbb::parallel_for(
        0, pieces, [&](int k) { piece(work, k); }, tbb::simple_partitioner());
  };
  arena_->tbb.execute(loop);
}

}  // namespace deformable_sim
