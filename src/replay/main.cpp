// replay_session: what `simulate --replay BAG` runs.
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/parallel/workers.h"
#include "deformable_sim/core/simd_level.h"
#include "deformable_sim/scene/progress.h"
#include "replay.h"

namespace {

using namespace deformable_sim;

constexpr int kEqual = 0, kDifferent = 1, kRefused = 2;

const char kUsage[] =
    "usage: simulate --replay BAG [--node NAME] [--threads N] [--quiet]\n"
    "\n"
    "Makes a session of the node again that rosbag has recorded (~session and ~<body>/state), without ROS running, "
    "and\n"
    "compares every recorded state bit by bit.\n"
    "\n"
    "--node NAME   whose session, where the bag has several\n"
    "--threads N   of the physics: the same bits\n"
    "--quiet       no progress\n"
    "\n"
    "Exit codes: 0 all states are equal, 1 some differ, 2 the bag or the scene in it was refused.\n";

struct Arguments {
  std::string bag, node;
  int threads = 1;
  bool quiet = false;
};

Arguments read_arguments(const std::vector<std::string>& words) {
  Arguments a;
  for (size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    const auto value = [&]() -> const std::string& {
      if (k + 1 >= words.size()) throw InputError(word + ": needs a value");
      return words[++k];
    };
    if (word == "--replay") {
      a.bag = value();
    } else if (word == "--node") {
      a.node = value();
    } else if (word == "--threads") {
      a.threads = std::atoi(value().c_str());
      if (a.threads < 1 || a.threads > Workers::kMost)
        throw InputError("--threads: allowed: 1 ... " + std::to_string(Workers::kMost));
    } else if (word == "--quiet") {
      a.quiet = true;
    } else {
      throw InputError("unknown option " + word + "; with --replay there is --node, --threads and --quiet");
    }
  }
  if (a.bag.empty()) throw InputError("--replay: no bag given");
  return a;
}

std::string count(int n, const std::string& what) {
  return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
}

int report(const ReplayResult& r) {
  std::cout << "replayed    " << count(r.sessions, "beginning") << ", " << r.steps << " steps, "
            << count(r.commands, "command") << "\n"
            << "states      " << r.equal << " equal, " << r.different << " different";
  if (r.uncovered > 0) std::cout << ", " << r.uncovered << " from before or after what the records tell of";
  std::cout << "\n";
  if (!r.depends.empty()) std::cout << "note        steps depend on the machine's load: " << r.depends << "\n";
  if (!r.machine.empty()) {
    std::cout << "note        recorded with " << r.machine << " kernels, here are " << name_of(simd_level())
              << ": DEFORMABLE_SIM_SIMD=" << r.machine << " takes the same where the machine has them\n";
  }
  if (r.different > 0) std::cout << "different   " << r.first_difference << "\n";
  if (r.equal + r.different == 0) {
    std::cerr << "simulate: the bag has no ~<body>/state to compare\n";
    return kRefused;
  }
  return r.different == 0 ? kEqual : kDifferent;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (std::find(words.begin(), words.end(), "--help") != words.end()) {
    std::cout << kUsage;
    return kEqual;
  }
  try {
    const Arguments arguments = read_arguments(words);
    const Recording recording = read_recording(arguments.bag, arguments.node);
    ReplayResult result;
    {
      Progress progress(Progress::fitting(arguments.quiet));
      const auto began = std::chrono::steady_clock::now();
      result = Replay(recording, arguments.threads).run([&](double share) {
        const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
        progress.show("replay", taken, taken * (1.0 - share) / share);
      });
    }
    return report(result);
  } catch (const InputError& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return kRefused;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return kDifferent;
  }
}
