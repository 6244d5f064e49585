// Ropes: error beside time. A rope of 1 m, 0.05 kg and EI = 1e-5 N m^2 (model: untwisted), held by one end, swings down
// from level for a second with 0.2 1/s of drag.
//
// error_percent = RMS distance of the nodes, at t = 0.25, 0.5, 0.75 and 1 s the largest, to a run of the same mesh with
// TR-BDF2 at 1/3840 s, each step solved to 1e-5 m/s^2, in percent of the rope's length. Time is thread CPU time.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr int kSamples = 4;
constexpr int kFramesPerSecond = 60;
constexpr int kLargestReference = 1000;  // nodes; beyond, a reference costs minutes: the error is not given

struct Setting {
  const char* integrator;
  int rate;  // steps a second
};
constexpr Setting kSettings[] = {{"bdf2", 240}, {"tr_bdf2", 480}, {"tr_bdf2", 960}};

using Samples = std::array<Nodes, kSamples>;

std::string whip(int nodes, double axial, const std::string& integrator, int rate, const std::string& more) {
  return "step: {dt: " + std::to_string(1e6 / rate) + "e-6, integrator: " + integrator + more +
         "}\nair: {damping: 0.2}\nbodies:\n  - rope:\n      name: rope\n      length: 1.0\n      segments: " +
         std::to_string(nodes - 1) +
         "\n      model: untwisted\n      pins: [end_0]\n      material: {linear_density: 0.05, damping: 0, "
         "axial_stiffness: " +
         std::to_string(axial) + ", bending_rigidity: [1.0e-5, 1.0e-5]}\n";
}

/// Positions at the quarters of a second; false when a step failed.
bool advance(World* world, int rate, Samples* out) {
  for (int k = 1; k <= rate; ++k) {
    if (!world->step().ok) return false;
    if (k % (rate / kSamples) == 0) (*out)[static_cast<size_t>(k / (rate / kSamples) - 1)] = world->state().x;
  }
  return true;
}

Samples reference(int nodes, double axial) {
  constexpr int kRate = 3840;
  Samples samples;
  advance(build(whip(nodes, axial, "tr_bdf2", kRate, ", tolerance: 1.0e-5, newton_iterations: 50")).get(), kRate,
          &samples);
  return samples;
}

/// Arguments: nodes, EA (N), which of kSettings. One iteration is one second of the rope.
void rope_whip(benchmark::State& state) {
  const auto nodes = static_cast<int>(state.range(0));
  const auto axial = static_cast<double>(state.range(1));
  const Setting& setting = kSettings[state.range(2)];
  Samples samples;
  for (auto _ : state) {
    state.PauseTiming();
    const auto world = build(whip(nodes, axial, setting.integrator, setting.rate, ""));
    state.ResumeTiming();
    if (!advance(world.get(), setting.rate, &samples)) {
      state.SkipWithError("a step failed");
      return;
    }
  }
  state.SetLabel(std::string(setting.integrator) + " 1/" + std::to_string(setting.rate));
  using Counter = benchmark::Counter;
  state.counters["nodes"] = nodes;
  state.counters["s_per_frame"] = Counter(kFramesPerSecond, Counter::kIsIterationInvariantRate | Counter::kInvert);
  if (nodes > kLargestReference) return;
  const Samples exact = reference(nodes, axial);
  double error = 0.0;
  for (size_t k = 0; k < kSamples; ++k) {
    error = std::max(error, std::sqrt((samples[k] - exact[k]).squaredNorm() / nodes));
  }
  state.counters["error_percent"] = 100.0 * error;
}

BENCHMARK(rope_whip)
    ->ArgsProduct({{50, 200, 1000}, {10000, 1000000}, {0, 1, 2}})
    ->ArgsProduct({{5000, 20000}, {1000000}, {0}})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
