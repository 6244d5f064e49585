#include "stability_command.h"

#include <filesystem>
#include <fstream>
#include <iostream>
#include <locale>
#include <optional>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/load.h"
#include "stability_map.h"

namespace deformable_sim::stability {

const char kUsage[] =
    "usage: study stability [--scene S] [--out DIR] [--budget CPU_SECONDS] [--quick] [--quiet]\n"
    "\n"
    "Sweeps integrator, linear solver, step (1e-6 ... 2 s), stiffness (1e2 ... 1e12 Pa), damping, mass ratio (1 ... "
    "1e6)\n"
    "and the aspect of cells (1 ... 1000), in slices of two, and says of each cell whether it is right to 1 %, "
    "bounded\n"
    "but wrong, or diverged; and measures the step limits of explicit schemes beside those of theory.\n"
    "\n"
    "--scene S   a file or a shipped scene in place of the bodies: its stiffnesses are scaled by 1e-4 ... 1e4\n"
    "--out DIR   writes stability.csv, stability_limits.csv and stability.txt there\n"
    "--budget S  CPU time, s (default 900; 120 with --quick); what it does not reach is left out, and counted\n"
    "--quick     few steps, few places, one linear solver\n"
    "--quiet     no progress\n"
    "\n"
    "Exit codes: 0 done, 1 the study could not be made, 2 the input was refused.\n";

namespace {

namespace fs = std::filesystem;

constexpr double kFullBudget = 900.0, kQuickBudget = 120.0, kMostBudget = 1e7;  // CPU s

struct Arguments {
  std::string scene, out;
  std::optional<double> budget;
  study::Effort effort = study::Effort::kFull;
  bool quiet = false;
};

double read_budget(const std::string& text) {
  double value = 0.0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> value;
  if (!stream || !stream.eof() || !(value > 0.0) || value > kMostBudget) {
    throw InputError("--budget: '" + text + "' is no time; allowed: > 0, <= 1e7 s");
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
    if (word == "--scene") {
      a.scene = value();
    } else if (word == "--out") {
      a.out = value();
    } else if (word == "--budget") {
      a.budget = read_budget(value());
    } else if (word == "--quick") {
      a.effort = study::Effort::kQuick;
    } else if (word == "--quiet") {
      a.quiet = true;
    } else {
      throw InputError("unknown option " + word + "; there is --scene, --out, --budget, --quick, --quiet and --help");
    }
  }
  return a;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream stream(path);
  stream << text;
  if (!stream.flush()) throw InputError("cannot write " + path.string());
}

}  // namespace

int command(const std::vector<std::string>& words) {
  const Arguments a = read_arguments(words);
  if (!a.out.empty()) {
    std::error_code error;
    fs::create_directories(a.out, error);
    if (error || !fs::is_directory(a.out)) throw InputError("cannot make the folder " + a.out);
  }
  SceneSpec scene;
  if (!a.scene.empty()) {
    scene = load_scene_file(find_scene(a.scene, default_scene_dir()));
    if (!scene.script.empty()) throw InputError(a.scene + ": has a script, which a study does not play");
  }
  Progress progress(Progress::fitting(a.quiet), work_precision::kLeft);
  const bool quick = a.effort == study::Effort::kQuick;
  const work_precision::Budget budget(a.budget.value_or(quick ? kQuickBudget : kFullBudget));
  const Map map = make_map(plan(a.effort, a.scene.empty() ? nullptr : &scene), budget, &progress);
  const std::string text = text_of(map);
  std::cout << text;
  if (a.out.empty()) return 0;
  const fs::path folder(a.out);
  write(folder / "stability.csv", csv_of(map));
  write(folder / "stability_limits.csv", limits_csv_of(map));
  write(folder / "stability.txt", text);
  progress.say("wrote " + (folder / "stability.csv").string() + ", stability_limits.csv and stability.txt");
  return 0;
}

}  // namespace deformable_sim::stability
