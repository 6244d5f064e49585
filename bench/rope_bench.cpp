// Ropes: error beside time. A rope of 1 m, 0.05 kg and EI = 1e-5 N m^2, for a second: held by one end it swings down
// from level with 0.2 1/s of drag (whip), or held by both, 0.6 m apart, it falls from a hanging arc with 1 1/s (drop).
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
constexpr Setting kSettings[] = {{"bdf2", 240}, {"tr_bdf2", 480}, {"tr_bdf2", 960}, {"tr_bdf2", 1200}};

using Samples = std::array<Nodes, kSamples>;

enum class Scene { kWhip, kDrop };

/// What is measured: model untwisted or rod.
struct Rope {
  Scene scene = Scene::kWhip;
  int nodes = 0;
  double axial = 0.0;  // N
  const char* model = "untwisted";
};

/// A chain of `segments` links of length `link` whose ends are `span` apart, all joints turned by the same angle.
Nodes arc(int segments, double link, double span) {
  Nodes x(3, segments + 1);
  double low = 0.0, high = 2.0 * M_PI / segments;  // straight, closed
  for (int k = 0; k < 60; ++k) {
    const double turn = 0.5 * (low + high);
    x.col(0).setZero();
    for (int i = 0; i < segments; ++i) {
      const double angle = turn * (0.5 * (segments - 1) - i);
      x.col(i + 1) = x.col(i) + link * Vec3(std::cos(angle), 0.0, -std::sin(angle));
    }
    (x(0, segments) > span ? low : high) = turn;
  }
  return x;
}

std::unique_ptr<World> make(const Rope& rope, const std::string& integrator, int rate, const std::string& more) {
  const bool drop = rope.scene == Scene::kDrop;
  auto world = build(
      "step: {dt: " + std::to_string(1e6 / rate) + "e-6, integrator: " + integrator + more +
      "}\nair: {damping: " + (drop ? "1.0" : "0.2") +
      "}\nbodies:\n  - rope:\n      name: rope\n      length: 1.0\n      segments: " + std::to_string(rope.nodes - 1) +
      "\n      model: " + rope.model + "\n      pins: [" + (drop ? "end_0, end_1" : "end_0") +
      "]\n      material: {linear_density: 0.05, damping: 0, axial_stiffness: " + std::to_string(rope.axial) +
      ", bending_rigidity: [1.0e-5, 1.0e-5]" + (rope.model == std::string("rod") ? ", twist_rigidity: 1.0e-5" : "") +
      "}\n");
  if (drop) {
    const Nodes x = arc(rope.nodes - 1, 1.0 / (rope.nodes - 1), 0.6);
    world->apply(command::SetBodyState{"rope", x, Nodes::Zero(3, x.cols()), {}});
  }
  return world;
}

/// Positions at the quarters of a second; false when a step failed.
bool advance(World* world, int rate, Samples* out, int* iterations) {
  for (int k = 1; k <= rate; ++k) {
    const StepOutcome outcome = world->step();
    if (!outcome.ok) return false;
    *iterations += outcome.report.newton_iterations;
    if (k % (rate / kSamples) == 0) {
      (*out)[static_cast<size_t>(k / (rate / kSamples) - 1)] = world->state().x.leftCols(world->model().point_count());
    }
  }
  return true;
}

Samples reference(const Rope& rope) {
  constexpr int kRate = 3840;
  Samples samples;
  int iterations = 0;
  advance(make(rope, "tr_bdf2", kRate, ", tolerance: 1.0e-5, newton_iterations: 50").get(), kRate, &samples,
          &iterations);
  return samples;
}

void measure(benchmark::State& state, const Rope& rope, const Setting& setting) {
  Samples samples;
  int iterations = 0;
  for (auto _ : state) {
    state.PauseTiming();
    const auto world = make(rope, setting.integrator, setting.rate, "");
    iterations = 0;
    state.ResumeTiming();
    if (!advance(world.get(), setting.rate, &samples, &iterations)) {
      state.SkipWithError("a step failed");
      return;
    }
  }
  state.SetLabel(std::string(setting.integrator) + " 1/" + std::to_string(setting.rate));
  using Counter = benchmark::Counter;
  state.counters["nodes"] = rope.nodes;
  state.counters["iterations"] = static_cast<double>(iterations) / setting.rate;
  state.counters["s_per_frame"] = Counter(kFramesPerSecond, Counter::kIsIterationInvariantRate | Counter::kInvert);
  if (rope.nodes > kLargestReference) return;
  const Samples exact = reference(rope);
  double error = 0.0;
  for (size_t k = 0; k < kSamples; ++k) {
    error = std::max(error, std::sqrt((samples[k] - exact[k]).squaredNorm() / rope.nodes));
  }
  state.counters["error_percent"] = 100.0 * error;
}

/// Arguments: nodes, EA (N), which of kSettings. One iteration is one second of the rope.
void rope_whip(benchmark::State& state) {
  const Rope rope{Scene::kWhip, static_cast<int>(state.range(0)), static_cast<double>(state.range(1))};
  measure(state, rope, kSettings[state.range(2)]);
}
void rope_drop(benchmark::State& state) {
  const Rope rope{Scene::kDrop, static_cast<int>(state.range(0)), static_cast<double>(state.range(1))};
  measure(state, rope, kSettings[state.range(2)]);
}
void rod_whip(benchmark::State& state) {
  const Rope rope{Scene::kWhip, static_cast<int>(state.range(0)), static_cast<double>(state.range(1)), "rod"};
  measure(state, rope, kSettings[state.range(2)]);
}

BENCHMARK(rope_whip)
    ->ArgsProduct({{50, 200, 1000}, {10000, 1000000}, {0, 1, 2, 3}})
    ->ArgsProduct({{5000, 20000}, {1000000}, {0}})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(rope_drop)
    ->ArgsProduct({{50, 200, 1000}, {10000, 1000000}, {0, 2}})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(rod_whip)->ArgsProduct({{50, 200, 1000}, {1000000}, {0, 1}})->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
