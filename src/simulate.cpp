// Headless simulation of a scene: load, build, step, report. No ROS.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <system_error>

#include <unistd.h>

#include "deformable_sim/core/parallel/workers.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/export_frames.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/progress.h"
#include "deformable_sim/scene/run_report.h"
#include "deformable_sim/scene/script.h"
#include "deformable_sim/scene/state_file.h"

namespace {

using namespace deformable_sim;

constexpr int kDone = 0, kFailed = 1, kRefused = 2, kInterrupted = 130;

const char kUsage[] =
    "usage: simulate SCENE [--seconds T] [--set KEY=VALUE]... [--out DIR] [--every S] [--format csv|ply|obj]\n"
    "                [--restore FILE] [--save FILE] [--threads N] [--quiet] [--json]\n"
    "       simulate --replay BAG [--node NAME] [--threads N] [--quiet]   (--replay --help)\n"
    "       simulate --scene-reference | --list | --help\n"
    "\n"
    "SCENE               a file, or the name of a shipped scene\n"
    "--seconds T         simulated time, s (default 5)\n"
    "--set KEY=VALUE     replaces any key of the scene by its path: --set bodies[0].cloth.cells=[40,30]\n"
    "--out DIR           writes frames: every node's position and velocity\n"
    "--every S           simulated time between frames, s (default 0.1)\n"
    "--format F          csv (default), ply or obj\n"
    "--restore FILE      begins where a simulation of the same scene was saved, and goes on to the same bits\n"
    "--save FILE         saves the simulation where it ends, also when it is interrupted\n"
    "--threads N         threads of the physics, 1 (default) ... 64: the same result, sooner where cores are free\n"
    "--quiet             no progress and no summary\n"
    "--json              ends with one JSON object on standard output; progress and summary go to standard error\n"
    "--scene-reference   prints the page of all scene keys\n"
    "--list              prints the folder of the shipped scenes and their names\n"
    "\n"
    "Exit codes: 0 done, 1 the simulation failed, 2 the input was refused, 130 interrupted (the summary is printed).\n";

struct Arguments {
  std::string scene;
  double seconds = 5.0;
  double every = 0.1;
  std::vector<Override> overrides;
  std::string out;
  std::string restore, save;
  FrameFormat format = FrameFormat::kCsv;
  int threads = 1;
  bool quiet = false;
  bool json = false;
};

volatile std::sig_atomic_t g_interrupted = 0;

void on_interrupt(int) {
  g_interrupted = 1;
}

double read_seconds(const std::string& option, const std::string& text) {
  double value = 0.0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> value;
  if (!stream || !stream.eof() || !std::isfinite(value) || value <= 0.0 || value > 1e6) {
    throw InputError(option + ": '" + text + "' is no time; allowed: > 0, <= 1e6 s");
  }
  return value;
}

int read_threads(const std::string& text) {
  int value = 0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> value;
  if (!stream || !stream.eof() || value < 1 || value > Workers::kMost) {
    throw InputError("--threads: '" + text + "' is no number of threads; allowed: 1 ... " +
                     std::to_string(Workers::kMost));
  }
  return value;
}

Override read_override(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) throw InputError("--set: '" + text + "' is not KEY=VALUE");
  return {text.substr(0, equals), text.substr(equals + 1)};
}

Arguments read_arguments(const std::vector<std::string>& words) {
  Arguments a;
  for (size_t k = 0; k < words.size(); ++k) {
    const std::string& word = words[k];
    const auto value = [&]() -> const std::string& {
      if (k + 1 >= words.size()) throw InputError(word + ": needs a value");
      return words[++k];
    };
    if (word == "--seconds") {
      a.seconds = read_seconds(word, value());
    } else if (word == "--every") {
      a.every = read_seconds(word, value());
    } else if (word == "--set") {
      a.overrides.push_back(read_override(value()));
    } else if (word == "--out") {
      a.out = value();
    } else if (word == "--format") {
      a.format = frame_format(value());
    } else if (word == "--restore") {
      a.restore = value();
    } else if (word == "--save") {
      a.save = value();
    } else if (word == "--threads") {
      a.threads = read_threads(value());
    } else if (word == "--quiet") {
      a.quiet = true;
    } else if (word == "--json") {
      a.json = true;
    } else if (word.size() > 1 && word[0] == '-') {
      throw InputError("unknown option " + word);
    } else if (!a.scene.empty()) {
      throw InputError("one scene at a time: '" + a.scene + "' and '" + word + "'");
    } else {
      a.scene = word;
    }
  }
  if (a.scene.empty()) throw InputError("no scene given");
  return a;
}

double seconds_of(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Steps a world and watches it: progress, frames, extremes.
class Run {
 public:
  Run(const Arguments& arguments, const SceneSpec& scene, World* world)
      : arguments_(arguments),
        world_(world),
        script_(scene.script),
        progress_(Progress::fitting(arguments.quiet)),
        began_(seconds_of(CLOCK_MONOTONIC)) {
    if (!arguments.restore.empty()) {
      const SavedState saved = read_state_file(arguments.restore);
      world->restore(saved.world);
      script_.go_on_after(saved.script);
      next_frame_ = next_look_ = start_ = world->time();
    }
    if (!arguments.out.empty()) frames_.emplace(arguments.out, arguments.format);
  }

  /// Throws InputError.
  void save(const std::string& scene) {
    write_state_file(arguments_.save, {scene, world_->time(), script_.taken(), world_->save(), ""});
  }

  RunReport report;

  /// Until the end, a failure or an interrupt.
  void go() {
    const double dt = world_->settings().dt;
    // A quotient of the two is a whole number up to rounding, which grows with it.
    const double count = std::ceil(arguments_.seconds / dt * (1.0 - 1e-12));
    watch();
    for (double k = 0; k < count && !g_interrupted; ++k) {
      if (!play_script()) break;
      const double cpu = seconds_of(CLOCK_PROCESS_CPUTIME_ID), wall = seconds_of(CLOCK_MONOTONIC);
      const StepOutcome outcome = world_->step();
      report.cpu_seconds += seconds_of(CLOCK_PROCESS_CPUTIME_ID) - cpu;
      report.wall_seconds += seconds_of(CLOCK_MONOTONIC) - wall;
      if (!outcome.ok) {
        report.error = outcome.message;
        break;
      }
      watch();
    }
    take(world_->snapshot());
    report.bill = world_->bill();
    report.solver = world_->settings().chosen;
  }

 private:
  static constexpr double kSlack = 1e-9;  // s: time is a sum of steps

  bool play_script() {
    const Reply reply = play(&script_, world_);
    if (!reply.status.ok()) report.error = reply.status.message;
    if (!reply.note.empty()) progress_.say(reply.note);
    return reply.status.ok();
  }

  void watch() {
    const double time = world_->time();
    const bool frame_due = frames_ && time >= next_frame_ - kSlack;
    const bool look_due = time >= next_look_ - kSlack;
    if (!frame_due && !look_due) return;
    const Snapshot now = world_->snapshot();
    take(now);
    if (frame_due) {
      frames_->write(now);
      next_frame_ += arguments_.every;
    }
    if (look_due) next_look_ = time + 0.05;
    show_progress(now);
  }

  void take(const Snapshot& now) {
    report.max_penetration = std::max(report.max_penetration, now.max_penetration);
    for (const BodyReport& body : now.bodies) report.max_strain = std::max(report.max_strain, body.max_strain);
    report.last = now;
  }

  void show_progress(const Snapshot& now) {
    const double wall = seconds_of(CLOCK_MONOTONIC) - began_, done = (now.time - start_) / arguments_.seconds;
    char text[80];
    std::snprintf(text, sizeof text, "%.2f s simulated, %.2f times real time, strain %.2f %%", now.time,
                  report.real_time_factor(), 100 * report.max_strain);
    progress_.show(text, wall, done > 0.0 ? wall * (1.0 - done) / done : 0.0);
  }

  const Arguments& arguments_;
  World* world_;
  Script script_;
  std::optional<FrameWriter> frames_;
  double next_frame_ = 0.0, next_look_ = 0.0;
  double start_ = 0.0;  // s, simulated
  Progress progress_;
  double began_ = 0.0;  // s, wall
};

int simulate(const Arguments& arguments) {
  const SceneSpec scene = load_scene_file(find_scene(arguments.scene, default_scene_dir()), arguments.overrides);
  const std::unique_ptr<World> world = build_world(scene, arguments.threads);
  Run run(arguments, scene, world.get());
  run.report.scene = scene.file;
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  run.go();
  if (!arguments.save.empty()) run.save(scene.file);
  const RunReport& report = run.report;
  if (!arguments.quiet) (arguments.json ? std::cerr : std::cout) << run_summary(report);
  if (arguments.json) std::cout << run_json(report) << "\n";
  if (!report.error.empty()) {
    std::cerr << "simulate: failed at " << report.last.time << " s: " << report.error << "\n";
    return kFailed;
  }
  return g_interrupted ? kInterrupted : kDone;
}

/// Bags are read by a program beside this one, which knows ROS. Returns where there is none.
int replay(char** argv) {
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error);
  execv((here.parent_path() / "replay_session").c_str(), argv);
  std::cerr << "simulate: --replay: this package was built without ROS, which bags need\n";
  return kRefused;
}

int list_scenes() {
  std::cout << default_scene_dir() << ":\n";
  for (const std::string& name : scene_names(default_scene_dir())) std::cout << "  " << name << "\n";
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto has = [&words](const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  if (has("--replay")) return replay(argv);
  if (has("--help") || has("-h")) {
    std::cout << kUsage;
    return kDone;
  }
  if (words.size() == 1 && words[0] == "--scene-reference") {
    std::cout << scene_reference();
    return kDone;
  }
  if (words.size() == 1 && words[0] == "--list") return list_scenes();
  Arguments arguments;
  try {
    arguments = read_arguments(words);
  } catch (const InputError& error) {
    std::cerr << "simulate: " << error.what() << "\n" << kUsage;
    return kRefused;
  }
  try {
    return simulate(arguments);
  } catch (const InputError& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return kRefused;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return kFailed;
  }
}
