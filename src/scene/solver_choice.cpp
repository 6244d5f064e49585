#include "deformable_sim/scene/solver_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace deformable_sim {
namespace {

constexpr size_t kNeighbours = 3;
constexpr double kSame = 0.02;    // distance at which a scene is the measured one
constexpr double kFar = 3.0;      // octaves more than the nearest: too far to have a say
constexpr double kOther = 4.0;    // octaves that contact counts, or a strain limit, where only one of two has it
constexpr double kStrange = 6.0;  // octaves to the nearest: what is expected there is a guess, and said to be one
constexpr double kTie = 1.2;      // costs that differ less are the same: no measurement is better
constexpr double kUnlike = 1.5;   // that errors of similar scenes are taken for
constexpr double kKnown = 0.3;    // of the weights: scenes that know a configuration must have so much
constexpr double kRound = 1e-6;   // of a step

struct Neighbour {
  const SolverTable::Scene* scene;
  double distance;  // octaves
  double weight;    // they sum to 1
};

struct Expected {
  size_t configuration;
  double error, cpu;
  int parts;
};

std::string number(double value, const char* form = "%.2g") {
  char text[40];
  std::snprintf(text, sizeof text, form, value);
  return text;
}

std::string percent(double value) {
  return number(100.0 * value) + " %";
}

double distance(const SceneFeatures& a, const SceneFeatures& b) {
  const double nodes = std::log2(static_cast<double>(a.nodes) / b.nodes);
  const double steps = std::log2(a.explicit_steps / b.explicit_steps);
  const double others = (a.contact != b.contact ? kOther : 0.0) + (a.strain_limits != b.strain_limits ? kOther : 0.0);
  return std::hypot(nodes, steps) + others;
}

/// The most similar scenes of the same bodies, nearest first; one alone where it is the same.
std::vector<Neighbour> neighbours(const SceneFeatures& scene, const SolverTable& table) {
  std::vector<Neighbour> found;
  for (const SolverTable::Scene& measured : table.scenes) {
    if (measured.features.bodies != scene.bodies) continue;
    found.push_back({&measured, distance(scene, measured.features), 0.0});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Neighbour& a, const Neighbour& b) { return a.distance < b.distance; });
  size_t count = 0;
  while (count < std::min(kNeighbours, found.size()) && found[count].distance <= found.front().distance + kFar) ++count;
  if (!found.empty() && found.front().distance < kSame) count = 1;
  found.resize(count);
  double sum = 0.0;
  for (Neighbour& n : found) sum += n.weight = 1.0 / (kSame + n.distance * n.distance);
  for (Neighbour& n : found) n.weight /= sum;
  return found;
}

/// How the cost of a configuration grows.
double work(const SolverConfiguration& configuration, const SceneFeatures& f) {
  return configuration.linear_solver.empty() ? f.nodes * f.explicit_steps : f.nodes;
}

/// What a configuration would do, from the scenes that know it; nothing where they have little say, or where it failed.
bool expect(const std::vector<Neighbour>& near, size_t index, const SolverConfiguration& configuration,
            const SceneFeatures& scene, Expected* expected) {
  double weight = 0.0, error = 0.0, cpu = 0.0;
  for (const Neighbour& n : near) {
    if (std::find(n.scene->failed.begin(), n.scene->failed.end(), index) != n.scene->failed.end()) return false;
    const auto run = std::find_if(n.scene->runs.begin(), n.scene->runs.end(),
                                  [index](const SolverTable::Run& r) { return r.configuration == index; });
    if (run == n.scene->runs.end()) {
      continue;
    }
    weight += n.weight;
    error += n.weight * std::log(run->error);
    cpu += n.weight * std::log(run->cpu / work(configuration, n.scene->features));
  }
  if (weight < kKnown) return false;
  const double unlike = near.front().distance < kSame ? 1.0 : kUnlike;
  *expected = {index, unlike * std::exp(error / weight), std::exp(cpu / weight) * work(configuration, scene), 1};
  return true;
}

/// For steps of a length that is given: in so many parts as are no longer than what was measured. The error is left
/// what it was with longer ones.
void fit_step(double dt, const SolverConfiguration& configuration, Expected* expected) {
  expected->parts = std::max(1, static_cast<int>(std::ceil(dt / configuration.dt - kRound)));
  if (!configuration.linear_solver.empty()) expected->cpu *= configuration.dt * expected->parts / dt;
}

/// The cheapest that is accurate enough, or what is more accurate at all but the same cost; else the most accurate
/// that can be paid for; else the cheapest.
const Expected& best(const std::vector<Expected>& all, const SolverWish& wish, std::string* remark) {
  const auto cheaper = [](const Expected& a, const Expected& b) { return a.cpu < b.cpu; };
  std::vector<Expected>::const_iterator cheapest = all.end(), finest = all.end();
  for (auto e = all.begin(); e != all.end(); ++e) {
    if (e->error <= wish.error && (cheapest == all.end() || cheaper(*e, *cheapest))) cheapest = e;
    if (e->cpu <= wish.budget && (finest == all.end() || e->error < finest->error)) finest = e;
  }
  if (cheapest != all.end() && cheapest->cpu <= wish.budget) {
    const double most = std::min(kTie * cheapest->cpu, wish.budget);
    return *std::min_element(all.begin(), all.end(), [most](const Expected& a, const Expected& b) {
      if ((a.cpu <= most) != (b.cpu <= most)) return a.cpu <= most;
      return a.error < b.error;
    });
  }
  if (finest != all.end()) {
    *remark = cheapest == all.end() ? "; nothing measured reaches it, this comes nearest"
                                    : "; it would take " + number(cheapest->cpu) +
                                          " CPU s/s, more than the budget of " + number(wish.budget);
    return *finest;
  }
  *remark = "; all take more than the budget of " + number(wish.budget) + " CPU s/s, this the least";
  return *std::min_element(all.begin(), all.end(), cheaper);
}

bool is_guess(const std::vector<Neighbour>& near) {
  return near.front().distance > kStrange;
}

std::string reason(const std::vector<Neighbour>& near, const SceneFeatures& scene, const SolverWish& wish,
                   const Expected& expected, const std::string& remark) {
  std::string text = "asked for an error of " + percent(wish.error) + ": about " + percent(expected.error) + " at " +
                     number(expected.cpu) + " CPU s/s, as measured on ";
  for (size_t k = 0; k < near.size(); ++k) {
    text +=
        (k == 0 ? "" : ", ") + near[k].scene->name + " (" + std::to_string(near[k].scene->features.nodes) + " nodes)";
  }
  text += remark;
  if (!scene.contact && near.front().scene->features.contact) text += "; those were measured in contact";
  if (scene.strain_limits != near.front().scene->features.strain_limits) text += "; strain limits are unlike theirs";
  if (is_guess(near)) text += "; unlike anything measured in nodes or stiffness: a guess";
  return text;
}

}  // namespace

std::string SolverConfiguration::text() const {
  std::string out = integrator;
  if (linear_solver.empty()) {
    if (precision != "double") out += " in " + precision + " precision";
    if (fraction_of_limit != 0.95) out += " at " + number(fraction_of_limit) + " of its limit";
    return out;
  }
  out += ", " + linear_solver;
  if (linear_iterations > 0) out += " to " + number(linear_tolerance) + " in " + std::to_string(linear_iterations);
  return out + ", Newton iterations " + std::to_string(newton_iterations);
}

SolverSettings settings_of(const SolverConfiguration& configuration, SolverSettings settings, bool ropes) {
  settings.precision =
      configuration.precision == "single" ? SolverSettings::Precision::kSingle : SolverSettings::Precision::kDouble;
  settings.fraction_of_limit = configuration.fraction_of_limit;
  if (configuration.linear_solver.empty()) return settings;
  const std::string& linear = configuration.linear_solver;
  settings.linear = linear == "banded"      ? SolverSettings::Linear::kBanded
                    : linear == "multigrid" ? SolverSettings::Linear::kMultigrid
                    : linear == "direct"    ? SolverSettings::Linear::kDirect
                                            : SolverSettings::Linear::kConjugateGradient;
  if (linear == "banded" && ropes) settings.jacobian = Jacobian::kLagged;
  if (configuration.linear_iterations > 0) {
    settings.linear_tolerance = configuration.linear_tolerance;
    settings.linear_iterations = configuration.linear_iterations;
  }
  settings.newton_iterations = configuration.newton_iterations;
  return settings;
}

SolverChoice choose_solver(const SceneFeatures& scene, const SolverWish& wish, const SolverTable& table,
                           const std::function<bool(const std::string&)>& can_run) {
  SolverChoice choice;
  const std::vector<Neighbour> near = neighbours(scene, table);
  std::vector<Expected> all;
  std::map<std::string, bool> runs;
  for (size_t k = 0; k < table.configurations.size(); ++k) {
    Expected expected{};
    const std::string& integrator = table.configurations[k].integrator;
    if (runs.count(integrator) == 0) runs[integrator] = can_run(integrator);
    if (!runs[integrator] || !expect(near, k, table.configurations[k], scene, &expected)) continue;
    if (wish.dt) fit_step(*wish.dt, table.configurations[k], &expected);
    all.push_back(expected);
  }
  // An impact is no smooth motion: one Newton iteration of a second order scheme may do for this and make energy there.
  const bool untouched = scene.contact && !near.empty() && !near.front().scene->features.contact;
  if (all.empty() || untouched) {
    choice.configuration = {"implicit_euler", "cg", 4, 0.1, 200, "double", 0.95, wish.dt.value_or(0.01)};
    choice.why = "nothing like it (" + scene.bodies + (untouched ? " in contact" : "") +
                 ") was measured: robust, its error unknown";
    return choice;
  }
  std::string remark;
  const Expected& chosen = best(all, wish, &remark);
  choice.configuration = table.configurations[chosen.configuration];
  if (wish.dt) choice.configuration.dt = *wish.dt;
  choice.parts = chosen.parts;
  choice.error = chosen.error;
  choice.cpu = chosen.cpu;
  choice.guessed = is_guess(near);
  choice.why = reason(near, scene, wish, chosen, remark);
  return choice;
}

}  // namespace deformable_sim
