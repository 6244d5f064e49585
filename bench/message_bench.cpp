// What the large messages weigh: serialised bytes per node, and the time to fill and serialise them.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>

#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/point_cloud.h"
#include "deformable_sim/ros/state_messages.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

template <typename Fill>
void measure(benchmark::State& state, const Fill& fill) {
  const std::unique_ptr<World> world = build(hanging_sheet(static_cast<int>(state.range(0)), Accuracy::kShipped, 0.0));
  for (int i = 0; i < 5; ++i) world->step();
  const Snapshot snapshot = world->snapshot();
  double bytes = 0.0;
  for (auto _ : state) {
    const ros::SerializedMessage message = ros::serialization::serializeMessage(fill(snapshot));
    benchmark::DoNotOptimize(message.buf.get());
    bytes = static_cast<double>(message.num_bytes);
  }
  const double nodes = world->model().node_count();
  using Counter = benchmark::Counter;
  state.counters["nodes"] = nodes;
  state.counters["bytes"] = bytes;
  state.counters["bytes_per_node"] = bytes / nodes;
  state.counters["s_per_node"] = Counter(nodes, Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void points(benchmark::State& state) {
  measure(state, [](const Snapshot& s) { return body_cloud(s, 0); });
}
void all_points(benchmark::State& state) {
  measure(state, [](const Snapshot& s) { return world_cloud(s); });
}
void body_state(benchmark::State& state) {
  measure(state, [](const Snapshot& s) { return body_state_message(s, 0, "world", ros::Time(1, 0)); });
}
void markers(benchmark::State& state) {
  measure(state, [](const Snapshot& s) { return body_marker(s, 0, OutputSpec()); });
}

BENCHMARK(points)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(all_points)->Arg(31);
BENCHMARK(body_state)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(markers)->Arg(16)->Arg(31)->Arg(61);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
