// What the large messages weigh: serialised bytes per node, and the time to fill and serialise them; and what the
// simulation thread spends on the snapshot they are made from.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>

#include "deformable_sim/core/topology/sheet_cut.h"
#include "deformable_sim/ros/body_drawing.h"
#include "deformable_sim/ros/point_cloud.h"
#include "deformable_sim/ros/shadow_drawing.h"
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
/// A model may not change once it is built; its snapshots may show another.
Snapshot with_look(const World& world, const SheetPattern& pattern, double thickness) {
  Snapshot snapshot = world.snapshot();
  auto model = std::make_shared<Model>();
  model->bodies = world.model().bodies;
  model->gravity = world.model().gravity;
  auto look = std::make_shared<SheetLook>();
  look->cut = cut_sheet(*model->bodies[0].surface, pattern);
  look->thickness = thickness;
  model->bodies[0].look = look;
  snapshot.model = model;
  return snapshot;
}
template <typename Fill>
void measure_look(benchmark::State& state, const SheetPattern& pattern, double thickness, const Fill& fill) {
  const std::unique_ptr<World> world = moving_sheet(static_cast<int>(state.range(0)));
  Snapshot snapshot = with_look(*world, pattern, thickness);
  Collider floor;
  floor.shapes.resize(1);
  floor.shapes[0].type = Shape::Type::kPlane;
  floor.world_from_collider.translation().z() = -10.0;
  snapshot.colliders.push_back(floor);
  double bytes = 0.0;
  for (auto _ : state) {
    const ros::SerializedMessage message = ros::serialization::serializeMessage(fill(snapshot));
    benchmark::DoNotOptimize(message.buf.get());
    bytes = static_cast<double>(message.num_bytes);
  }
  report(state, *world, bytes);
}
const auto kBody = [](const Snapshot& s) { return body_marker(s, 0, OutputSpec()); };
void checkered(benchmark::State& state) {
  measure_look(state, {0.07, 0.0}, 0.0, kBody);
}
void checkered_seams_thick(benchmark::State& state) {
  measure_look(state, {0.07, 0.015}, 0.003, kBody);
}
void shadows(benchmark::State& state) {
  measure_look(state, {}, 0.0, [](const Snapshot& s) { return shadow_marker(s, 0); });
}

BENCHMARK(snapshot)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(snapshot_with_reports)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(points)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(all_points)->Arg(31);
BENCHMARK(body_state)->Arg(16)->Arg(31)->Arg(61);
BENCHMARK(markers)->Arg(16)->Arg(31)->Arg(61)->Arg(100);
BENCHMARK(markers_by_strain)->Arg(31);
BENCHMARK(checkered)->Arg(31)->Arg(100);
BENCHMARK(checkered_seams_thick)->Arg(31)->Arg(100);
BENCHMARK(shadows)->Arg(31)->Arg(100);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
