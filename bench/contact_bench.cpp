// What contact alone costs in a frame of 1/60 s, in scenes that run: sheets draped over moving obstacles and crumpled,
// a rope in a knot, next to the same detection in plain loops (contact_baseline.h) on the same states.
//
// Contact alone is what the world's bill calls contact and contact of bodies; forces, linear solver and Newton
// iterations are not in it. CPU time of the thread, mean over the frames measured, which follow a warm-up from the
// start of the scene. Before and after, what the library finds is compared with what the baseline finds: a case in
// which they differ is an error. Arguments: --drape=, --crumple=, --knot=, each with numbers of nodes (segments);
// --warm_up= in s.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <sstream>
#include <vector>

#include "contact_baseline.h"
#include "contact_check.h"
#include "contact_scenes.h"
#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kFrame = 1.0 / 60.0;
constexpr int kWindow = 50;          // steps: those that a snapshot's costs are the mean of
constexpr int kBaselineRepeats = 3;  // the fastest counts
constexpr double kUnbilled = 0.2;    // of a step, at most: else the window is not the one measured

struct Options {
  std::vector<int> drape{1024, 2500, 10000, 40000}, crumple{1024, 2500, 10000}, knot{1000};
  double warm_up = 5.0 / 3.0;  // s
};

/// Sums over the steps measured.
struct Totals {
  double step = 0.0, baseline = 0.0;  // s
  int repeated = 0, parts = 0, newton = 0;
  double least_distance = 1.0, penetration = 0.0;
};

/// Runs whole windows that take `seconds` or a little more; false and the reason where a step fails.
bool warm_up(ContactScene* scene, double seconds, benchmark::State* state) {
  const double dt = scene->world->settings().dt;
  const int windows = static_cast<int>(std::ceil(seconds / dt / kWindow - 1e-9));
  for (int k = 0; k < windows * kWindow; ++k) {
    scene->command();
    const StepOutcome outcome = scene->world->step();
    if (outcome.ok) continue;
    state->SkipWithError(outcome.message.c_str());
    return false;
  }
  return true;
}

bool same_contacts(const World& world, ContactBaseline* baseline, benchmark::State* state) {
  const ContactComparison found = compare_contacts(world, baseline);
  state->counters["contacts_of_bodies"] = found.between_bodies;
  state->counters["contacts_on_colliders"] = found.on_colliders;
  if (found.missed + found.surplus == 0) return true;
  std::ostringstream text;
  text << "other contacts than the baseline: " << found.missed << " missed, " << found.surplus << " more; "
       << found.first;
  state->SkipWithError(text.str().c_str());
  return false;
}

double baseline_seconds(const World& world, const std::vector<Collider>& colliders, ContactBaseline* baseline) {
  double best = 0.0;
  for (int k = 0; k < kBaselineRepeats; ++k) {
    const double start = thread_cpu_time();
    baseline->find(world.state().x, world.state().v, world.settings().dt, colliders);
    const double spent = thread_cpu_time() - start;
    if (k == 0 || spent < best) best = spent;
  }
  return best;
}

bool run_window(ContactScene* scene, ContactBaseline* baseline, Totals* sum, benchmark::State* state) {
  World& world = *scene->world;
  Snapshot now = world.snapshot(SnapshotDetail::kMotion);
  for (int k = 0; k < kWindow; ++k) {
    scene->command();
    sum->baseline += baseline_seconds(world, now.colliders, baseline);
    const double start = thread_cpu_time();
    const StepOutcome outcome = world.step();
    sum->step += thread_cpu_time() - start;
    if (!outcome.ok) {
      state->SkipWithError(outcome.message.c_str());
      return false;
    }
    now = world.snapshot(SnapshotDetail::kMotion);
    sum->repeated += now.substeps > world.settings().parts ? 1 : 0;
    sum->parts += now.substeps;
    sum->newton += outcome.report.newton_iterations;
    sum->penetration = std::max(sum->penetration, now.max_penetration);
    sum->least_distance = std::min(sum->least_distance, least_distance_share(world, baseline));
  }
  return true;
}

void report(const World& world, const Totals& sum, benchmark::State* state) {
  const double per_frame = kFrame / (kWindow * world.settings().dt);
  double contact = 0.0, billed = 0.0;
  for (const PartCost& cost : world.snapshot().cost) {
    billed += kFrame * cost.seconds_per_second;
    if (cost.part == "contact" || cost.part == "contact of bodies") contact += kFrame * cost.seconds_per_second;
  }
  const double step = sum.step * per_frame, baseline = sum.baseline * per_frame;
  if (billed > step || billed < (1.0 - kUnbilled) * step) {
    state->SkipWithError("the bill is of other steps than those measured");
    return;
  }
  state->counters["nodes"] = world.model().point_count();
  state->counters["contact_ms"] = 1e3 * contact;
  state->counters["baseline_ms"] = 1e3 * baseline;
  state->counters["frame_ms"] = 1e3 * step;
  state->counters["unbilled_ms"] = 1e3 * (step - billed);
  state->counters["steps_per_frame"] = kFrame / world.settings().dt;
  state->counters["repeated_percent"] = 100.0 * sum.repeated / kWindow;
  state->counters["parts_per_step"] = 1.0 * sum.parts / kWindow;
  state->counters["newton_per_step"] = 1.0 * sum.newton / kWindow;
  state->counters["least_distance"] = sum.least_distance;
  state->counters["penetration"] = sum.penetration;
}

void measure(benchmark::State& state, const std::function<ContactScene()>& make, double seconds) {
  for (auto _ : state) {
    ContactScene scene = make();
    const World& world = *scene.world;
    ContactBaseline baseline(world.model());
    baseline.set_colliders(world.snapshot(SnapshotDetail::kMotion).colliders);
    Totals sum;
    if (!warm_up(&scene, seconds, &state) || !same_contacts(world, &baseline, &state) ||
        !run_window(&scene, &baseline, &sum, &state)) {
      return;
    }
    report(world, sum, &state);
    same_contacts(world, &baseline, &state);
  }
}

void register_all(const Options& options) {
  const auto add = [&](const char* name, ContactScene (*make)(int), const std::vector<int>& sizes) {
    for (const int size : sizes) {
      benchmark::RegisterBenchmark((std::string(name) + "/" + std::to_string(size)).c_str(),
                                   [=](benchmark::State& state) {
                                     measure(
                                         state, [=] { return make(size); }, options.warm_up);
                                   })
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    }
  };
  add("drape", draped_sheet, options.drape);
  add("crumple", crumpled_sheet, options.crumple);
  add("knot", knotted_rope, options.knot);
}

/// Takes its own arguments out of those left; false for one it does not know.
bool parse(int argc, char** argv, Options* options) {
  for (int k = 1; k < argc; ++k) {
    const char* equals = std::strchr(argv[k], '=');
    const std::string key(argv[k], equals == nullptr ? std::strlen(argv[k]) : static_cast<size_t>(equals - argv[k]));
    std::istringstream value(equals == nullptr ? "" : equals + 1);
    std::vector<int>* sizes = key == "--drape"     ? &options->drape
                              : key == "--crumple" ? &options->crumple
                              : key == "--knot"    ? &options->knot
                                                   : nullptr;
    if (sizes != nullptr) {
      sizes->clear();
      for (std::string size; std::getline(value, size, ',');) sizes->push_back(std::stoi(size));
    } else if (key != "--warm_up" || !(value >> options->warm_up)) {
      std::fprintf(stderr, "unknown argument %s\n", argv[k]);
      return false;
    }
  }
  return true;
}

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  deformable_sim::bench::Options options;
  if (!deformable_sim::bench::parse(argc, argv, &options)) return 2;
  deformable_sim::bench::register_all(options);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
