// Loops whose pieces run on several threads.
#pragma once

#include <memory>

namespace deformable_sim {

/// Threads that share the pieces of a loop. What is cut into pieces, and the order in which their results are added up,
/// is the scene's matter and never depends on how many threads there are: so the bits of a result do not either.
///
/// Not good at: pieces of less than some microseconds (a loop costs 1 to 2 us on threads that are awake, and tens where
/// they have to be woken); cores that other processes want, since a loop ends with its last piece.
class Workers {
 public:
  static constexpr int kMost = 64;

  /// The caller's thread counts, so 1 is no thread beside it; more than there are cores are as many as there are cores.
  /// Throws InputError outside 1 ... kMost.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return threads_; }

  /// work(k) once for every k = 0 ... pieces - 1, in any order and several at a time; returns when all are done. May be
  /// called from within a piece. Throws what a piece throws; others may then be left out.
  template <class Work>
  void for_each(int pieces, const Work& work) const {
    if (arena_ == nullptr || pieces < 2) {
      for (int k = 0; k < pieces; ++k) work(k);
      return;
    }
    run(
        pieces, [](const void* some, int k) { (*static_cast<const Work*>(some))(k); }, &work);
  }

 private:
  struct Arena;
  void run(int pieces, void (*piece)(const void*, int), const void* work) const;

  int threads_;
  std::unique_ptr<Arena> arena_;  // null: one thread
};

/// The same where null stands for one thread.
template <class Work>
void for_each_piece(const Workers* workers, int pieces, const Work& work) {
  if (workers != nullptr) return workers->for_each(pieces, work);
  for (int k = 0; k < pieces; ++k) work(k);
}

}  // namespace deformable_sim
