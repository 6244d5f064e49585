// Loops whose pieces run on several threads.
#pragma once

#include <memory>

namespace deformable_sim {

/// Threads that share the pieces of a loop. What is cut into pieces, and the order in which their results are added up,
/// is the scene's matter and never depends on how many threads there are: so the bits of a result do not either.
///
/// The other threads take part during a Shift: they come with its first loop, as soon as they find a core, look for
/// pieces without sleeping, which makes loops of a few microseconds worth while, and leave when it ends. The caller
/// waits for none of them: it works through what nobody has taken, so that a thread without a core is no loss. One that
/// loses its core in the middle of a piece is waited for.
///
/// Not good at: pieces of less than a microsecond; machines whose cores are all taken.
class Workers {
 public:
  static constexpr int kMost = 64;
  /// Bodies that are solved each by itself are shared out from so many nodes on, of all together: about a tenth of a
  /// millisecond.
  static constexpr int kLeastSolvedNodes = 500;

  /// The caller's thread counts, so 1 is no thread beside it; more than there are cores are as many as there are cores.
  /// Throws InputError outside 1 ... kMost.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int threads() const { return threads_; }
  /// Whether any loop has been shared so far.
  bool have_shared() const;

  /// work(k) once for every k = 0 ... pieces - 1, in any order and several at a time; returns when all are done. From
  /// within a piece: one by one. Throws what a piece throws; others may then be left out.
  template <class Work>
  void for_each(int pieces, const Work& work) const {
    if (team_ == nullptr || pieces < 2) {
      for (int k = 0; k < pieces; ++k) work(k);
      return;
    }
    run({[](const void* some, int k) { (*static_cast<const Work*>(some))(k); }, &work, pieces});
  }

  /// From its construction to its end the other threads take part; without one, they do not. Null: nothing happens.
  class Shift {
   public:
    explicit Shift(const Workers* workers);
    ~Shift();
    Shift(const Shift&) = delete;
    Shift& operator=(const Shift&) = delete;

   private:
    const Workers* workers_;
  };

 private:
  struct Team;
  struct Loop {
    void (*piece)(const void*, int);
    const void* work;
    int pieces;
  };
  void run(const Loop& loop) const;
  void call_others() const;

  int threads_;
  std::shared_ptr<Team> team_;  // null: one thread
};

/// The same where null stands for one thread.
template <class Work>
void for_each_piece(const Workers* workers, int pieces, const Work& work) {
  if (workers != nullptr) return workers->for_each(pieces, work);
  for (int k = 0; k < pieces; ++k) work(k);
}

}  // namespace deformable_sim
