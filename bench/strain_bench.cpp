// Strain of a hanging sheet as shipped, against the converged solution of the same mesh.
#include <benchmark/benchmark.h>

#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr double kDamping = 4.0;     // 1/s: brings the sheet to rest without changing where it rests
constexpr double kRestSpeed = 1e-4;  // m/s, RMS
constexpr double kLongest = 60.0;    // s of simulated time

/// Steps until the sheet rests; the strain it rests at.
double settle(World* world, benchmark::State* state) {
  do {
    const StepOutcome outcome = world->step();
    if (!outcome.ok) {
      state->SkipWithError(outcome.message.c_str());
      return 0.0;
    }
  } while (world->time() < 1.0 || (rms_speed(*world) > kRestSpeed && world->time() < kLongest));
  return max_strain(*world);
}

/// One iteration = the whole settling, so its time is not a step's; see step_bench for that.
void strain_error(benchmark::State& state) {
  const int side = static_cast<int>(state.range(0));
  double shipped = 0.0, seconds = 0.0;
  for (auto _ : state) {
    const std::unique_ptr<World> world = build(hanging_sheet(side, Accuracy::kShipped, kDamping));
    shipped = settle(world.get(), &state);
    seconds = world->time();
  }
  const std::unique_ptr<World> reference = build(hanging_sheet(side, Accuracy::kConverged, kDamping));
  const double converged = settle(reference.get(), &state);
  state.counters["nodes"] = side * side;
  state.counters["simulated_s"] = seconds;
  state.counters["real_time_factor"] = benchmark::Counter(seconds, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["max_strain"] = shipped;
  state.counters["converged_strain"] = converged;
  state.counters["strain_error"] = shipped - converged;
  state.counters["reference_speed"] = rms_speed(*reference);
}

BENCHMARK(strain_error)->Arg(16)->Arg(31)->Arg(61)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
