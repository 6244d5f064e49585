// Studies. The virtual test bench puts a material of the tables on simulated specimens and reports what is measured;
// work_precision finds what a scene's error costs, stability where steps are stable and right. No ROS.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/material_library.h"
#include "deformable_sim/scene/progress.h"
#include "study/bench.h"
#include "study/fuzz_command.h"
#include "study/solver_report.h"
#include "study/stability_command.h"
#include "study/work_precision_command.h"

namespace {

using namespace deformable_sim;

constexpr int kDone = 0, kFailed = 1, kRefused = 2;

const char kUsage[] =
    "usage: study material MATERIAL [--model M] [--out DIR] [--quick] [--json] [--quiet]\n"
    "       study work_precision SCENE | --suite ...      (study work_precision --help)\n"
    "       study fuzz               scenes made at random, stepped and watched   (study fuzz --help)\n"
    "       study stability [--scene S] ...               (study stability --help)\n"
    "       study solvers            what solver: auto chooses for the scenes of config/solvers.yaml, and how good it "
    "is\n"
    "       study --list | --models | --material-reference | --help\n"
    "       ./run study verify [--only TESTS] [--out DIR]   (in a checkout: every yardstick, see doc/verification.md)\n"
    "\n"
    "MATERIAL              a name of config/materials (study --list)\n"
    "--model M             how the body is modelled (study --models), or all; default: the model that suits the "
    "material\n"
    "--out DIR             writes MATERIAL.json and MATERIAL.csv there\n"
    "--quick               two coarse meshes and no drape\n"
    "--json                prints JSON instead of the table\n"
    "--quiet               no progress\n"
    "--material-reference  prints the page of all materials\n"
    "\n"
    "Exit codes: 0 done, 1 a test could not be made, 2 the input was refused.\n";

struct Arguments {
  std::string material, model, out;
  study::Effort effort = study::Effort::kFull;
  bool json = false, quiet = false;
};

Arguments read_arguments(const std::vector<std::string>& words) {
  if (words.empty() || words[0] != "material")
    throw InputError("'" + (words.empty() ? "" : words[0]) +
                     "': the first word must be 'material', 'work_precision', 'stability', 'fuzz' or 'solvers', or the "
                     "only one --list, --models, --material-reference or --help");
  Arguments a;
  for (size_t k = 1; k < words.size(); ++k) {
    const std::string& word = words[k];
    const auto value = [&]() -> const std::string& {
      if (k + 1 >= words.size()) throw InputError(word + ": needs a value");
      return words[++k];
    };
    if (word == "--model") {
      a.model = value();
    } else if (word == "--out") {
      a.out = value();
    } else if (word == "--quick") {
      a.effort = study::Effort::kQuick;
    } else if (word == "--json") {
      a.json = true;
    } else if (word == "--quiet") {
      a.quiet = true;
    } else if (word.size() > 1 && word[0] == '-') {
      throw InputError("unknown option " + word + "; there is --model, --out, --quick, --json, --quiet and --help");
    } else if (!a.material.empty()) {
      throw InputError("one material at a time: '" + a.material + "' and '" + word + "'");
    } else {
      a.material = word;
    }
  }
  if (a.material.empty()) throw InputError("no material given; study --list names them");
  return a;
}

/// The models asked for: one, all, or the one that suits.
std::vector<std::string> chosen(const std::string& asked, const std::vector<std::string>& all,
                                const std::string& suitable) {
  if (asked == "all") return all;
  return {asked.empty() ? suitable : asked};
}

class Studies {
 public:
  explicit Studies(const Arguments& arguments)
      : arguments_(arguments),
        progress_(Progress::fitting(arguments.quiet)),
        bench_{arguments.effort, [this](const std::string& test) { tell(test); }} {}

  void operator()(const SolidData& solid) {
    for (const auto& m : choose(study::solid_models(), solid.law + "_quadratic"))
      show(study::study_solid(solid, m, bench_));
  }
  void operator()(const FabricData& fabric) {
    for (const auto& m : choose(study::cloth_models(), "membrane")) show(study::study_cloth(fabric, m, bench_));
  }
  void operator()(const RopeData& rope) {
    for (const auto& m : choose(study::rope_models(), "rod")) show(study::study_rope(rope, m, bench_));
  }

  std::vector<study::Report> reports;

 private:
  static constexpr double kUsual = 25.0;  // measurements of a model

  std::vector<std::string> choose(const std::vector<std::string>& all, const std::string& suitable) {
    const std::vector<std::string> models = chosen(arguments_.model, all, suitable);
    models_ = models.size();
    return models;
  }
  void show(const study::Report& report) {
    progress_.wipe();
    if (!arguments_.json) std::cout << (reports.empty() ? "" : "\n") << study::text_of(report) << std::flush;
    reports.push_back(report);
    measured_ = 0.0;
  }
  void tell(const std::string& test) {
    const double here = std::min(measured_++ / kUsual, 1.0), whole = static_cast<double>(models_);
    const double share = std::max(1e-3, (static_cast<double>(reports.size()) + here) / whole);
    const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
    progress_.show(test, taken, taken * (1.0 - share) / share);
  }

  const Arguments& arguments_;
  Progress progress_;
  study::Bench bench_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  size_t models_ = 1;
  double measured_ = 0.0;  // of the present model
};

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream stream(path);
  stream << text;
  if (!stream.flush()) throw InputError("cannot write " + path.string());
}

/// Before the study, not after it: a minute's work should not end on a folder that cannot be.
void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error || !std::filesystem::is_directory(path)) throw InputError("cannot make the folder " + path);
}

int study_material(const Arguments& arguments) {
  const MaterialLibrary library = load_material_library(default_material_dir());
  const auto material = library.find(arguments.material);
  if (!arguments.out.empty()) make_folder(arguments.out);
  Studies studies(arguments);
  std::visit(studies, material);
  if (arguments.json) std::cout << study::json_of(studies.reports);
  if (!arguments.out.empty()) {
    const std::filesystem::path base = std::filesystem::path(arguments.out) / arguments.material;
    write(base.string() + ".json", study::json_of(studies.reports));
    write(base.string() + ".csv", study::csv_of(studies.reports));
    std::cerr << "wrote " << base.string() << ".json and .csv\n";
  }
  return kDone;
}

void list(const std::string& heading, const std::vector<std::string>& names) {
  std::cout << heading << ":\n";
  for (const std::string& name : names) std::cout << "  " << name << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto has = [&words](const char* word) { return std::find(words.begin(), words.end(), word) != words.end(); };
  const bool precision = !words.empty() && words[0] == "work_precision";
  const bool fuzzed = !words.empty() && words[0] == "fuzz", stable = !words.empty() && words[0] == "stability";
  if (words.empty() || has("--help") || has("-h")) {
    (words.empty() ? std::cerr : std::cout) << (precision ? work_precision::kUsage
                                                : fuzzed  ? fuzz::kUsage
                                                : stable  ? stability::kUsage
                                                          : kUsage);
    return words.empty() ? kRefused : kDone;
  }
  try {
    if (precision) return work_precision::command({words.begin() + 1, words.end()});
    if (fuzzed) return fuzz::command({words.begin() + 1, words.end()});
    if (stable) return stability::command({words.begin() + 1, words.end()});
    if (words.size() == 1 && words[0] == "--material-reference") {
      std::cout << material_reference(load_material_library(default_material_dir()));
      return kDone;
    }
    if (words.size() == 1 && words[0] == "solvers") {
      std::cout << study::solver_report(read_solver_table(solver_table_file()));
      return kDone;
    }
    if (words.size() == 1 && words[0] == "--list") {
      list(default_material_dir(), load_material_library(default_material_dir()).names());
      return kDone;
    }
    if (words.size() == 1 && words[0] == "--models") {
      list("fabrics", study::cloth_models());
      list("ropes", study::rope_models());
      list("solids", study::solid_models());
      return kDone;
    }
    return study_material(read_arguments(words));
  } catch (const InputError& error) {
    std::cerr << "study: " << error.what() << "\n";
    return kRefused;
  } catch (const std::exception& error) {
    std::cerr << "study: " << error.what() << "\n";
    return kFailed;
  }
}
