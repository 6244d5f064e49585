#include "solver_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

namespace deformable_sim::study {
namespace {

struct Choice {
  const SolverTable::Run* run = nullptr;  // null: the scene was not run so, or failed
  std::string text;
};

Choice choose(const SolverTable::Scene& scene, double error, const SolverTable& table) {
  const SolverChoice made = choose_solver(scene.features, {error, std::numeric_limits<double>::infinity(), {}}, table);
  Choice choice;
  choice.text = made.configuration.text();
  for (const SolverTable::Run& run : scene.runs) {
    const SolverConfiguration& k = table.configurations[run.configuration];
    if (made.measured() && k.text() == choice.text && k.dt == made.configuration.dt) choice.run = &run;
  }
  char dt[40];
  std::snprintf(dt, sizeof dt, ", dt %.4g ms", 1e3 * made.configuration.dt);
  choice.text += dt;
  return choice;
}

/// Of choices made without the scene.
struct Tally {
  int all = 0, met = 0, unknown = 0;
  std::vector<double> off, ratio;

  void add(const Choice& choice, const SolverTable::Cheapest& wanted) {
    ++all;
    if (choice.run == nullptr) {
      ++unknown;
      return;
    }
    met += choice.run->error <= wanted.error;
    off.push_back(choice.run->error / wanted.error);
    ratio.push_back(choice.run->cpu / wanted.cpu);
  }

  std::string text() {
    if (off.empty()) return "";
    std::sort(off.begin(), off.end());
    std::sort(ratio.begin(), ratio.end());
    char line[300];
    std::snprintf(line, sizeof line,
                  "\nchosen without the scene itself: %d choices, error met by %d, not run there or diverged %d; error "
                  "over the wanted one: largest %.2g; cost over the cheapest: median %.2f, largest %.2f\n",
                  all, met, unknown, off.back(), ratio[ratio.size() / 2], ratio.back());
    return line;
  }
};

}  // namespace

std::string solver_report(const SolverTable& table) {
  std::string out;
  Tally alone;
  double dearest = 0.0;
  for (size_t k = 0; k < table.scenes.size(); ++k) {
    const SolverTable::Scene& scene = table.scenes[k];
    SolverTable others = table;
    others.scenes.erase(others.scenes.begin() + static_cast<std::ptrdiff_t>(k));
    char line[400];
    std::snprintf(line, sizeof line, "%s (%s, %d nodes, %.3g explicit steps a frame)\n", scene.name.c_str(),
                  scene.features.bodies.c_str(), scene.features.nodes, scene.features.explicit_steps);
    out += line;
    for (const SolverTable::Cheapest& wanted : scene.cheapest) {
      const Choice own = choose(scene, wanted.error, table), foreign = choose(scene, wanted.error, others);
      alone.add(foreign, wanted);
      if (own.run == nullptr) continue;
      dearest = std::max(dearest, own.run->cpu / wanted.cpu);
      std::snprintf(line, sizeof line, "  <= %-5g %%  %-66s %.2g %%, %.2f of the cheapest; ", 100.0 * wanted.error,
                    own.text.c_str(), 100.0 * own.run->error, own.run->cpu / wanted.cpu);
      out += line;
      if (foreign.run == nullptr) {
        out += "without it: " + foreign.text + ", which it was not run with\n";
        continue;
      }
      std::snprintf(line, sizeof line, "without it: %s %.2g %%, %.2f\n",
                    foreign.run == own.run ? "the same" : foreign.text.c_str(), 100.0 * foreign.run->error,
                    foreign.run->cpu / wanted.cpu);
      out += line;
    }
  }
  char line[100];
  std::snprintf(line, sizeof line, "\ncost over the cheapest of the same error: at most %.2f\n", dearest);
  return out + line + alone.text();
}

}  // namespace deformable_sim::study
