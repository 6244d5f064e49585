// What the large messages weigh: serialised bytes per node, and the time to fill and serialise them; and what the
// simulation thread spends on the snapshot they are made from.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>

#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/point_cloud.h"
#include "deformable_sim/ros/state_messages.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

std::unique_ptr<World> moving_sheet(int side) {
  std::unique_ptr<World> world = build(hanging_sheet(side, Accuracy::kShipped, 0.0));
  for (int i = 0; i < 5; ++i) world->step();
  return world;
}

void report(benchmark::State& state, const World& world, double bytes) {
  const double nodes = world.model().node_count();
  using Counter = benchmark::Counter;
  state.counters["nodes"] = nodes;
  state.counters["bytes"] = bytes;
  state.counters["bytes_per_node"] = bytes / nodes;
  state.counters["s_per_node"] = Counter(nodes, Counter::kIsIterationInvariantRate | Counter::kInvert);
}

template <typename Fill>
void measure(benchmark::State& state, const Fill& fill) {
  const std::unique_ptr<World> world = moving_sheet(static_cast<int>(state.range(0)));
  const Snapshot snapshot = world->snapshot();
  double bytes = 0.0;
  for (auto _ : state) {
    const ros::SerializedMessage message = ros::serialization::serializeMessage(fill(snapshot));
    benchmark::DoNotOptimize(message.buf.get());
    bytes = static_cast<double>(message.num_bytes);
  }
  report(state, *world, bytes);
}

void measure_snapshot(benchmark::State& state, SnapshotDetail detail) {
  const std::unique_ptr<World> world = moving_sheet(static_cast<int>(state.range(0)));
  double bytes = 0.0;
  for (auto _ : state) {
    const Snapshot snapshot = world->snapshot(detail);
    bytes = static_cast<double>(sizeof(double)) * static_cast<double>(snapshot.x.size() + snapshot.v.size());
  }
  report(state, *world, bytes);
}

void snapshot(benchmark::State& state) {
  measure_snapshot(state, SnapshotDetail::kMotion);
}
void snapshot_with_reports(benchmark::State& state) {
  measure_snapshot(state, SnapshotDetail::kReports);
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
void markers_by_strain(benchmark::State& state) {
  OutputSpec outputs;
  outputs.color_by = "strain";
  measure(state, [&outputs](const Snapshot& s) { return body_marker(s, 0, outputs); });
}

BENCHMARK(snapshot)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(snapshot_with_reports)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(points)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(all_points)->Arg(31);
BENCHMARK(body_state)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(markers)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(markers_by_strain)->Arg(31);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
