#include "work_precision_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <locale>
#include <optional>
#include <sstream>

#include "bench.h"
#include "work_precision_front.h"
#include "work_precision_parts.h"
#include "work_precision_plan.h"
#include "work_precision_reference.h"
#include "work_precision_report.h"
#include "work_precision_store.h"
#include "work_precision_sweep.h"

namespace deformable_sim::work_precision {

const char kUsage[] =
    "usage: study work_precision SCENE | --suite [--seconds T] [--out DIR] [--budget S] [--resume] [--quick] "
    "[--quiet]\n"
    "                            [--set KEY=VALUE]...\n"
    "\n"
    "SCENE            a file, the name of a shipped scene or of one of the suite (study work_precision --list)\n"
    "--suite          the scenes of config/suite, a ladder of stiffnesses, shipped scenes and golden trajectories\n"
    "--seconds T      simulated time, s (default 1; a golden trajectory has its own)\n"
    "--out DIR        writes NAME.csv, NAME.json and NAME.summary.json there, and NAME.runs.csv while it runs\n"
    "--budget S       CPU time for a scene, s (default 600; 60 with --quick)\n"
    "--resume         goes on where a study of the same scene and program was interrupted; with --out\n"
    "--quick          few configurations and steps\n"
    "--quiet          no progress\n"
    "--store          (./run study) writes config/solvers.yaml, which `solver: auto` chooses from, of all results in "
    "DIR\n"
    "--set KEY=VALUE  replaces any key of the scene by its path\n"
    "\n"
    "Exit codes: 0 done, 1 a study could not be made, 2 the input was refused.\n";

namespace {

namespace fs = std::filesystem;

constexpr int kDone = 0;
constexpr double kFullBudget = 600.0, kQuickBudget = 60.0;  // CPU s
constexpr double kReferenceShare = 0.35, kSweepEnd = 0.85;  // of the budget; the rest is for mesh and model
constexpr double kPerRun = 1.0 / 15.0;
constexpr double kTight = 1e-6;        // m/s^2
constexpr double kPartsError = 0.001;  // of the run that measures mesh and model

struct Arguments {
  std::vector<std::string> scenes;
  std::optional<double> seconds, budget;
  std::string out;
  study::Effort effort = study::Effort::kFull;
  std::vector<Override> overrides;
  bool suite = false, resume = false, quiet = false;
};

double read_number(const std::string& option, const std::string& text, double most) {
  double value = 0.0;
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  stream >> value;
  if (!stream || !stream.eof() || !(value > 0.0) || value > most) {
    std::ostringstream allowed;
    allowed << option << ": '" << text << "' is no time; allowed: > 0, <= " << most << " s";
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
    if (word == "--suite") {
      a.suite = true;
    } else if (word == "--seconds") {
      a.seconds = read_number(word, value(), 1e3);
    } else if (word == "--budget") {
      a.budget = read_number(word, value(), 1e7);
    } else if (word == "--out") {
      a.out = value();
    } else if (word == "--resume") {
      a.resume = true;
    } else if (word == "--quick") {
      a.effort = study::Effort::kQuick;
    } else if (word == "--quiet") {
      a.quiet = true;
    } else if (word == "--set") {
      const std::string& text = value();
      const size_t equals = text.find('=');
      if (equals == std::string::npos || equals == 0) throw InputError("--set: '" + text + "' is not KEY=VALUE");
      a.overrides.emplace_back(text.substr(0, equals), text.substr(equals + 1));
    } else if (word.size() > 1 && word[0] == '-') {
      throw InputError("unknown option " + word);
    } else {
      a.scenes.push_back(word);
    }
  }
  if (a.suite && !a.scenes.empty()) throw InputError("either --suite or a scene, not both");
  if (a.suite && !a.overrides.empty()) throw InputError("--set: changes one scene, not --suite");
  if (a.suite) {
    for (const SuiteEntry& entry : suite()) a.scenes.push_back(entry.name);
  }
  if (a.scenes.empty()) throw InputError("no scene given");
  if (!a.suite && a.scenes.size() > 1) {
    throw InputError("one scene at a time: '" + a.scenes[0] + "' and '" + a.scenes[1] + "'");
  }
  if (a.resume && a.out.empty()) throw InputError("--resume: needs --out");
  return a;
}

std::unique_ptr<Case> make_case(const Arguments& a, const std::string& scene) {
  const std::vector<std::string> golden = golden_names();
  if (std::find(golden.begin(), golden.end(), scene) != golden.end()) {
    if (a.seconds && !a.suite) throw InputError("--seconds: a golden trajectory has its own");
    if (!a.overrides.empty()) throw InputError("--set: a golden trajectory has no keys");
    return golden_case(scene);
  }
  SuiteEntry chosen{"", scene, {}};
  for (const SuiteEntry& entry : suite()) {
    if (entry.name == scene) chosen = entry;
  }
  chosen.overrides.insert(chosen.overrides.end(), a.overrides.begin(), a.overrides.end());
  std::unique_ptr<Case> c = scene_case(chosen.scene, chosen.overrides, a.seconds.value_or(1.0));
  if (!chosen.name.empty()) c->name = chosen.name;
  return c;
}

void write(const std::string& path, const std::string& text) {
  std::ofstream stream(path);
  stream << text;
  if (!stream.flush()) throw InputError("cannot write " + path);
}

/// The cheapest row that is good enough to measure mesh and model with, else the best there is; null: there is none.
const Row* good_row(const Result& result) {
  for (const int k : result.front) {
    const Row& row = result.rows[static_cast<size_t>(k)];
    if (row.errors.position <= kPartsError) return &row;
  }
  return result.front.empty() ? nullptr : &result.rows[static_cast<size_t>(result.front.back())];
}

Result study_case(const Case& c, const Arguments& a, Progress* progress) {
  const double total = a.budget.value_or(a.effort == study::Effort::kQuick ? kQuickBudget : kFullBudget);
  const Budget budget(total);
  const std::string base = a.out.empty() ? "" : (fs::path(a.out) / c.name).string();
  Result result;
  result.name = c.name;
  result.title = c.title;
  result.digest = c.digest;
  result.version = program_version();
  result.seconds = c.seconds;
  result.features = c.features;
  progress->say(c.name + ": " + c.title);

  const UsableSteps usable = usable_steps(c);
  const double verlet = usable.at("velocity_verlet");
  if (std::isnan(result.features.explicit_steps)) result.features.explicit_steps = 1.0 / (60.0 * verlet);
  const std::unique_ptr<World> start = c.make(verlet, "velocity_verlet", c.solver);
  const Yardstick yardstick(start->shared_model(), start->state());

  const std::string reference_file = base + ".reference";
  const bool known = a.resume && read_reference(reference_file, c.digest, result.version, &result.reference);
  if (!known) {
    result.reference = find_reference(c, yardstick, verlet, kReferenceShare * total, progress);
    if (!base.empty()) write_reference(reference_file, c.digest, result.version, result.reference);
  }

  RunLog log;
  if (!base.empty()) {
    const RunLog::Start from = a.resume ? RunLog::Start::kResume : RunLog::Start::kAnew;
    log = RunLog(base + ".runs.csv", c.digest, result.version, from);
    if (log.known() > 0) progress->say("resumed: " + std::to_string(log.known()) + " runs are known");
  }
  const double tight = tight_tolerance(c, verlet, kTight), per_run = kPerRun * total;
  Sweep sweep({&c, &yardstick, &result.reference, tight, verlet, per_run, kSweepEnd * total, &budget, &log, progress});
  sweep.go(plan(c, usable, a.effort));
  result.rows = sweep.rows();
  result.left_out = sweep.left_out();
  result.front = pareto_front(result.rows, result.reference.resolution());
  result.picks = picks(result.rows, result.reference.resolution());

  if (const Row* with = good_row(result)) {
    progress->show("a finer mesh", budget.spent(), budget.left());
    result.mesh = mesh_part(c, yardstick, result.reference, *with, tight, 0.6 * budget.left());
    progress->show("the other model", budget.spent(), budget.left());
    result.model = model_part(c, yardstick, result.reference, *with, tight, budget.left());
  } else {
    result.mesh.how = result.model.how = "no run to measure it with";
  }
  return result;
}

void list_scenes() {
  std::cout << "the suite:\n";
  for (const SuiteEntry& entry : suite()) std::cout << "  " << entry.name << "\n";
  std::cout << default_scene_dir() << ":\n";
  for (const std::string& name : scene_names(default_scene_dir())) std::cout << "  " << name << "\n";
}

}  // namespace

int command(const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0] == "--list") {
    list_scenes();
    return kDone;
  }
  const Arguments a = read_arguments(words);
  if (!a.out.empty()) fs::create_directories(a.out);
  Progress progress(Progress::fitting(a.quiet), kLeft);
  for (const std::string& scene : a.scenes) {
    const std::unique_ptr<Case> c = make_case(a, scene);
    const Result result = study_case(*c, a, &progress);
    std::cout << text_of(result) << (a.suite ? "\n" : "") << std::flush;
    if (a.out.empty()) continue;
    const std::string base = (fs::path(a.out) / result.name).string();
    write(base + ".csv", csv_of(result));
    write(base + ".json", json_of(result));
    write(base + ".summary.json", summary_of(result));
    progress.say("wrote " + base + ".csv, .json and .summary.json");
  }
  return kDone;
}

}  // namespace deformable_sim::work_precision
