// Cost of a step: thread CPU time per node and step, and the real-time factor that follows.
#include <benchmark/benchmark.h>

#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr int kSteps = 200;  // 2 s of simulated time at the shipped step: the fall, the impact and the swing after it

/// Advances a world once per iteration; the first step, which builds its work space, is not counted.
void measure(benchmark::State& state, const std::string& scene) {
  const std::unique_ptr<World> world = build(scene);
  world->step();
  double newton = 0.0, linear = 0.0, penetration = 0.0;
  for (auto _ : state) {
    const StepOutcome outcome = world->step();
    if (!outcome.ok) {
      state.SkipWithError(outcome.message.c_str());
      break;
    }
    newton += outcome.report.newton_iterations;
    linear += outcome.report.linear_iterations;
  }
  penetration = world->snapshot().max_penetration;
  const double nodes = world->model().node_count();
  using Counter = benchmark::Counter;
  state.counters["nodes"] = nodes;
  state.counters["s_per_node_step"] = Counter(nodes, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["real_time_factor"] = Counter(world->settings().dt, Counter::kIsIterationInvariantRate);
  state.counters["newton_per_step"] = newton / kSteps;
  state.counters["linear_per_step"] = linear / kSteps;
  state.counters["max_strain"] = max_strain(*world);
  state.counters["max_penetration"] = penetration;
}

void towel_falling(benchmark::State& state) {
  measure(state, falling_towel());
}
void towel_hanging(benchmark::State& state) {
  measure(state, hanging_towel());
}
void sheet_hanging(benchmark::State& state) {
  measure(state, hanging_sheet(static_cast<int>(state.range(0)), Accuracy::kShipped, 0.0));
}
void sheet_sphere(benchmark::State& state) {
  measure(state, sheet_on_sphere(static_cast<int>(state.range(0))));
}
void rope_swinging(benchmark::State& state) {
  measure(state, rope(static_cast<int>(state.range(0))));
}

BENCHMARK(towel_falling)->Iterations(kSteps)->Unit(benchmark::kMillisecond);
BENCHMARK(towel_hanging)->Iterations(kSteps)->Unit(benchmark::kMillisecond);
BENCHMARK(sheet_hanging)->Arg(16)->Arg(31)->Arg(61)->Iterations(kSteps)->Unit(benchmark::kMillisecond);
BENCHMARK(sheet_sphere)->Arg(16)->Arg(31)->Iterations(kSteps)->Unit(benchmark::kMillisecond);
BENCHMARK(rope_swinging)
    ->Arg(50)
    ->Arg(100)
    ->Arg(200)
    ->Arg(500)
    ->Arg(1000)
    ->Iterations(kSteps)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
