// One case stepped and watched.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace deformable_sim::fuzz {

/// What a gain of energy is called that a warning gives, where the program chose the solver.
constexpr char kOfAuto[] = "energy of auto";

/// What is wrong, as one word; empty: nothing. These are failures of the program:
///
///   crash, hang         the process ended by a signal, or a step took more than 10 s of CPU time
///   exception           anything but an InputError
///   not_finite          a NaN or an infinity in the state, a report, a wrench or a contact
///   far                 a node beyond 1e4 m within the second
///   energy              more energy than there was, with nothing that moves or blows; see Watch
///   hidden              a node is inside a collider by more than the snapshot's max_penetration says
///   crossing            an edge goes through a triangle, of bodies that keep apart
///   moved_by_stop       a step that could not be made changed the state
///   dead_after_stop     ... or no step can be made after a reset
///   reset, repeat, threads, restore   other bits after a reset, in a second run, on two threads, after a restore
///   stop                a solver that was chosen by the program could not make a step
///
/// A solver that the scene itself names may stop honestly: kStopped. Any may gain energy where a warning says so, by
/// the next look of the books: kSaid, as "energy", or kOfAuto where the program chose the solver.
struct Outcome {
  enum class End { kDone, kCut, kRefused, kStopped, kSaid, kFound };
  End end = End::kDone;
  std::string what;    // the word
  std::string detail;  // a sentence
  std::string integrator;
  double time = 0.0;  // s, simulated
  int steps = 0;
  int refused_commands = 0;
  double cpu = 0.0;        // thread CPU time, s
  std::uint64_t bits = 0;  // digest of all states
};

struct Limits {
  double seconds = 1.0;                         // simulated
  double cpu = 0.25;                            // thread CPU time, s: beyond it the run is cut
  int steps = std::numeric_limits<int>::max();  // for runs that are compared
  int threads = 1;
  /// Called once, before the first step: the integrator, and whether the scene may ask for steps of any cost: it names
  /// an explicit scheme, which divides a step into as many parts as it takes.
  std::function<void(const std::string& integrator, bool any_cost)> begins;
};

/// Loads the text as the file `origin`, with its commands, and steps it.
Outcome run_case(const std::string& text, const std::string& origin, const Limits& limits);

/// run_case(); where that found nothing, again: after a reset, in a new world, and on two threads, in the same bits.
Outcome compare_case(const std::string& text, const std::string& origin, const Limits& limits);

enum class Depth { kOnce, kCompared };
/// The same in a process of its own, which may crash or hang.
Outcome run_isolated(const std::string& text, const std::string& origin, const Limits& limits, Depth depth);

}  // namespace deformable_sim::fuzz
