// Whether the largest sheet runs in real time on one core while it falls on a ball, and how long it takes to begin.
//
// The scene is bench/drape_160.yaml; all times are CPU time of the thread. start_s: loading, building and the first
// step. real_time_factor: simulated over CPU time of two seconds after it; slowest: of the quarter of a second that
// took longest. Residual: RMS unbalanced acceleration at the ends of the steps, their mean.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kSeconds = 2.0;
constexpr int kWindows = 8;

void measure(benchmark::State& state, const std::vector<Override>& changes) {
  for (auto _ : state) {
    double began = thread_cpu_time();
    const SceneSpec scene = load_scene_file(package_dir() + "/bench/drape_160.yaml", changes);
    const std::unique_ptr<World> world = build_world(scene);
    world->step();
    state.counters["start_s"] = thread_cpu_time() - began;
    const double dt = world->settings().dt;
    const int window = std::max(1, static_cast<int>(std::lround(kSeconds / kWindows / dt)));
    double seconds = 0.0, slowest = 0.0, newton = 0.0, residual = 0.0, penetration = 0.0;
    for (int w = 0; w < kWindows; ++w) {
      began = thread_cpu_time();
      for (int k = 0; k < window; ++k) {
        const StepOutcome outcome = world->step();
        if (!outcome.ok) return state.SkipWithError(outcome.message.c_str());
        newton += outcome.report.newton_iterations;
        residual += outcome.report.residual;
      }
      const double spent = thread_cpu_time() - began;
      seconds += spent;
      slowest = std::max(slowest, spent);
      const Snapshot now = world->snapshot(SnapshotDetail::kMotion);
      penetration = std::max(penetration, now.max_penetration);
    }
    const double steps = kWindows * window;
    state.counters["nodes"] = world->model().point_count();
    state.counters["real_time_factor"] = steps * dt / seconds;
    state.counters["slowest"] = window * dt / slowest;
    state.counters["ms_per_frame"] = 1e3 * seconds / (steps * dt) / 60.0;
    state.counters["newton_per_step"] = newton / steps;
    state.counters["residual"] = residual / steps;
    state.counters["max_penetration"] = penetration;
    state.counters["max_strain"] = max_strain(*world);
  }
}

void drape_160(benchmark::State& state) {
  measure(state, {});
}
void drape_160_two_newton(benchmark::State& state) {
  measure(state, {{"step.newton_iterations", "2"}});
}
void drape_160_bdf2(benchmark::State& state) {
  measure(state, {{"step.integrator", "bdf2"}});
}
void drape_160_auto(benchmark::State& state) {
  measure(state, {{"step", "{solver: auto}"}});
}

BENCHMARK(drape_160)->Iterations(1);
BENCHMARK(drape_160_two_newton)->Iterations(1);
BENCHMARK(drape_160_bdf2)->Iterations(1);
BENCHMARK(drape_160_auto)->Iterations(1);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
