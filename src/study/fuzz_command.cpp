#include "fuzz_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <locale>
#include <map>
#include <sstream>

#include <sys/resource.h>
#include <unistd.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/progress.h"
#include "fuzz_reduce.h"
#include "fuzz_run.h"
#include "fuzz_scene.h"
#include "fuzz_tally.h"
#include "work_precision_budget.h"

namespace deformable_sim::fuzz {

const char kUsage[] =
    "usage: study fuzz [--scenes N] [--first SEED] [--seconds T] [--budget S] [--out DIR] [--compare N] [--patient N]\n"
    "                  [--all] [--quiet]\n"
    "       study fuzz --show SEED | --case FILE [--seconds T]\n"
    "\n"
    "Makes scenes at random, steps each in a process of its own, and watches every step.\n"
    "\n"
    "--scenes N     how many (default 100)\n"
    "--first SEED   of the first; the others follow (default 1)\n"
    "--seconds T    simulated time of each, s (default 1)\n"
    "--budget S     CPU time for all, s (default 600); a scene that takes more than 0.25 s is cut short\n"
    "--out DIR      writes cases.csv, summary.txt, and every failure cut down to a small scene there\n"
    "--compare N    every N-th case is run again, after a reset, on two threads and from a state saved half way: the\n"
    "               same bits (default 20, 0 never)\n"
    "--patient N    every N-th case is cut short after 5 s instead (default 20, 0 never)\n"
    "--all          also cuts down what solvers that the scene names could not step\n"
    "--quiet        no progress\n"
    "--show SEED    prints the scene of a seed\n"
    "--case FILE    runs a file that was written by --out\n"
    "\n"
    "Exit codes: 0 no failure, 1 some, 2 the input was refused.\n";

namespace {

namespace fs = std::filesystem;

constexpr int kDone = 0, kFailed = 1;
constexpr long kToEstimate = 20;   // scenes, the time that all will take
constexpr long kKeepEvery = 100;   // scenes: what is known is written
constexpr int kKept = 2;           // failures of one kind that are cut down
constexpr double kReduced = 15.0;  // CPU s for each, at most
constexpr double kPatience = 5.0;  // CPU s for a case, of some

struct Arguments {
  long scenes = 100, first = 1, compare = 20, patient = 20;
  double seconds = 1.0, budget = 600.0;
  std::string out, file;
  long show = -1;
  bool all = false, quiet = false;
};

double read_number(const std::string& option, const std::string& text, double least, double most) {
  double value = 0.0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> value;
  if (!stream || !stream.eof() || !(value >= least) || value > most) {
    std::ostringstream allowed;
    allowed << option << ": '" << text << "' is out of range; allowed: " << least << " ... " << most;
    throw InputError(allowed.str());
  }
  return value;
}

Arguments read_arguments(const std::vector<std::string>& words) {
  Arguments a;
  for (size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    const auto value = [&]() -> const std::string& {
      if (k + 1 >= words.size()) throw InputError(word + ": needs a value");
      return words[++k];
    };
    const auto whole = [&](double least, double most) {
      return static_cast<long>(read_number(word, value(), least, most));
    };
    if (word == "--scenes") {
      a.scenes = whole(1, 1e7);
    } else if (word == "--first") {
      a.first = whole(0, 1e12);
    } else if (word == "--compare") {
      a.compare = whole(0, 1e7);
    } else if (word == "--patient") {
      a.patient = whole(0, 1e7);
    } else if (word == "--seconds") {
      a.seconds = read_number(word, value(), 1e-3, 1e3);
    } else if (word == "--budget") {
      a.budget = read_number(word, value(), 1, 1e7);
    } else if (word == "--out") {
      a.out = value();
    } else if (word == "--show") {
      a.show = whole(0, 1e12);
    } else if (word == "--case") {
      a.file = value();
    } else if (word == "--all") {
      a.all = true;
    } else if (word == "--quiet") {
      a.quiet = true;
    } else {
      throw InputError("fuzz: unknown word '" + word + "'");
    }
  }
  return a;
}

/// CPU time of this process and of those it waited for, s.
double all_cpu_time() {
  double sum = 0.0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(whose, &used);
    for (const timeval& t : {used.ru_utime, used.ru_stime})
      sum += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return sum;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream stream(path);
  stream << text;
  if (!stream.flush()) throw InputError("cannot write " + path.string());
}

/// A folder for the meshes: the one asked for, or one of this process that goes with it.
class Folder {
 public:
  explicit Folder(const std::string& out) : path_(out), made_(out.empty()) {
    if (made_) path_ = (fs::temp_directory_path() / ("deformable_sim_fuzz_" + std::to_string(getpid()))).string();
    std::error_code error;
    fs::create_directories(path_, error);
    if (error || !fs::is_directory(path_)) throw InputError("cannot make the folder " + path_);
    write_meshes(path_);
  }
  ~Folder() {
    std::error_code error;
    if (made_) fs::remove_all(path_, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string file(const std::string& name) const { return (fs::path(path_) / name).string(); }

 private:
  std::string path_;
  bool made_;
};

/// The case cut down, with what is wrong with it in its first lines.
std::string reduced(const Case& failing, const Outcome& outcome, const std::string& origin, Limits limits,
                    Depth depth) {
  const double until = all_cpu_time() + kReduced;
  if (outcome.steps > 0) limits.seconds = std::min(limits.seconds, 1.001 * outcome.time + 1e-6);
  const auto same = [&](const Outcome& o) { return o.what == outcome.what && o.end == outcome.end; };
  const Case small = reduce(failing, [&](const Case& trial) {
    return all_cpu_time() < until && same(run_isolated(text_of(trial), origin, limits, depth));
  });
  const Outcome last = run_isolated(text_of(small), origin, limits, depth);
  return "# " + last.what + ": " + last.detail + "\n" + text_of(small);
}

class Campaign {
 public:
  explicit Campaign(const Arguments& a)
      : a_(a), folder_(a.out), progress_(Progress::fitting(a.quiet), work_precision::kLeft) {}

  int run() {
    limits_.seconds = a_.seconds;
    for (long k = 0; k < a_.scenes; ++k) {
      const double spent = all_cpu_time();
      if (spent >= a_.budget) break;
      const double each = k < kToEstimate ? a_.budget : spent / static_cast<double>(k);
      const double whole = std::min(a_.budget, each * static_cast<double>(a_.scenes));
      progress_.show("scene " + std::to_string(k + 1), spent, std::max(0.0, whole - spent));
      const bool compared = a_.compare > 0 && k % a_.compare == 0;
      const bool patient = a_.patient > 0 && k % a_.patient == a_.patient / 2;  // others than are compared, mostly
      one(static_cast<std::uint64_t>(a_.first + k), compared, patient);
      if (k % kKeepEvery == 0) keep();
    }
    std::cout << tally_.text() << std::flush;
    keep();
    return tally_.failures() > 0 ? kFailed : kDone;
  }

 private:
  void keep() const {
    if (a_.out.empty()) return;
    write(folder_.file("cases.csv"), tally_.csv());
    write(folder_.file("summary.txt"), tally_.text());
  }

  void one(std::uint64_t seed, bool compared, bool patient) {
    const Case c = make_case(seed);
    Limits limits = limits_;
    if (patient) limits.cpu = kPatience;
    const Depth depth = compared ? Depth::kCompared : Depth::kOnce;
    const std::string origin = folder_.file("seed_" + std::to_string(seed) + ".yaml");
    const Outcome outcome = run_isolated(text_of(c), origin, limits, depth);
    tally_.add(seed, outcome, compared, patient);
    const bool stopped = outcome.end == Outcome::End::kStopped;
    if (outcome.end != Outcome::End::kFound && !stopped) return;
    const std::string kind = (stopped ? "stopped_" + outcome.integrator : outcome.what);
    if (!stopped) progress_.say("seed " + std::to_string(seed) + ": " + outcome.what + ": " + outcome.detail);
    if (a_.out.empty() || (stopped && !a_.all) || ++kept_[kind] > kKept) return;
    write(folder_.file(kind + "_" + std::to_string(seed) + ".yaml"), reduced(c, outcome, origin, limits, depth));
  }

  const Arguments& a_;
  Folder folder_;
  Progress progress_;
  Limits limits_;
  Tally tally_;
  std::map<std::string, int> kept_;
};

int run_file(const Arguments& a) {
  std::ifstream stream(a.file);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError(a.file + ": cannot be read", Code::kNotFound);
  Limits limits;
  limits.seconds = a.seconds;
  limits.cpu = a.budget;
  const Outcome o = compare_case(text.str(), a.file, limits);
  if (o.end == Outcome::End::kRefused) throw InputError(o.detail);
  const char* const said = o.end == Outcome::End::kSaid ? "said in a warning: " : "";
  std::cout << said << (o.what.empty() ? "nothing wrong" : o.what + ": " + o.detail) << "; " << o.steps << " steps of "
            << o.integrator << ", " << o.time << " s, " << o.cpu << " s CPU\n";
  return o.end == Outcome::End::kFound ? kFailed : kDone;
}

}  // namespace

int command(const std::vector<std::string>& words) {
  const Arguments a = read_arguments(words);
  if (a.show >= 0) {
    std::cout << text_of(make_case(static_cast<std::uint64_t>(a.show)));
    return kDone;
  }
  if (!a.file.empty()) return run_file(a);
  return Campaign(a).run();
}

}  // namespace deformable_sim::fuzz
