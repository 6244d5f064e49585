// What a picture of a depth camera costs, and how wrong it is: 640 x 480 pixels of a sheet of 2,500 nodes above four
// obstacles. Nothing moves, so that what is seen is known in closed form.
#include <benchmark/benchmark.h>
#include <ros/serialization.h>

#include <algorithm>
#include <cmath>

#include "deformable_sim/core/camera/depth_noise.h"
#include "deformable_sim/ros/camera/camera_messages.h"
#include "deformable_sim/ros/camera/camera_view.h"
#include "scenes.h"

namespace deformable_sim {
namespace bench {
namespace {

constexpr const char* kScene = R"(
bodies:
  - cloth: {name: sheet, size: [0.5, 0.5], cells: [49, 49], pose: {position: [0, 0, 0.3]}}
colliders:
  - plane: {name: table}
  - sphere: {name: ball, radius: 0.1, pose: {position: [0.4, 0, 0.2]}}
  - box: {name: crate, size: [0.1, 0.2, 0.1], pose: {position: [-0.4, 0, 0.05], rpy: [0.2, 0.3, 0.4]}}
  - cylinder: {name: can, radius: 0.05, length: 0.15, pose: {position: [0.4, 0.25, 0.1], rpy: [0.5, 0, 0]}}
)";

/// One metre above the middle of the sheet, looking straight down.
Pose from_above() {
  Pose pose = Pose::Identity();
  pose.linear() = Vec3(1, -1, -1).asDiagonal();
  pose.translation() = Vec3(0, 0, 1);
  return pose;
}

struct Studio {
  std::unique_ptr<World> world = build(kScene);
  Snapshot snapshot = world->snapshot(SnapshotDetail::kMotion);
  SegmentIds segment_ids;
  SegmentIds::OfSnapshot ids = segment_ids.of(snapshot);
  Pinhole camera;
  DepthBuffer buffer{camera};

  void draw() {
    buffer.clear();
    draw_world(snapshot, ids, from_above(), &buffer);
  }

  /// Largest |depth - closed form| (m) on sheet, table and ball. The ball's nearer point along the unit ray e is at
  /// e . c - sqrt(r^2 - |c|^2 + (e . c)^2); within a tenth of a millimetre of its outline float32 decides nothing.
  double error() const {
    const std::vector<float> depth = buffer.depth();
    const Vec3 ball = from_above().inverse() * Vec3(0.4, 0.0, 0.2);
    double worst = 0.0;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const auto pixel = static_cast<std::size_t>(v * camera.width + u);
        const std::uint16_t label = buffer.labels()[pixel];
        double expected = depth[pixel];
        if (label == ids.bodies[0]) expected = 0.7;
        if (label == ids.colliders[0]) expected = 1.0;
        if (label == ids.colliders[1]) {
          const Vec3 e = camera.ray(u, v).normalized();
          const double along = e.dot(ball), root = 0.01 - ball.squaredNorm() + along * along;
          expected = (along - std::sqrt(std::max(root, 0.0))) * e.z();
        }
        worst = std::max(worst, std::abs(depth[pixel] - expected));
      }
    }
    return worst;
  }
};

template <typename Picture>
void measure(benchmark::State& state, const Picture& picture) {
  Studio studio;
  for (auto _ : state) {
    studio.draw();
    picture(studio);
  }
  state.counters["nodes"] = studio.world->model().node_count();
  state.counters["error_mm"] = 1e3 * studio.error();
}

template <typename Message>
void send(const Message& message) {
  benchmark::DoNotOptimize(ros::serialization::serializeMessage(message).buf.get());
}

void draw_only(benchmark::State& state) {
  measure(state, [](Studio& studio) { benchmark::DoNotOptimize(studio.buffer.labels().data()); });
}
void depth(benchmark::State& state) {
  measure(state, [](Studio& studio) { send(depth_image(studio.camera, studio.buffer.depth())); });
}
void segmentation(benchmark::State& state) {
  measure(state, [](Studio& studio) { send(segmentation_image(studio.camera, studio.buffer.labels())); });
}
void points(benchmark::State& state) {
  measure(state,
          [](Studio& studio) { send(camera_cloud(studio.camera, studio.buffer.depth(), studio.buffer.labels())); });
}
/// The error is that of the picture before noise.
void noisy_depth(benchmark::State& state) {
  DepthNoise noise;
  noise.sigma = 0.0012;
  noise.sigma_growth = 0.0019;
  noise.sigma_distance = 0.4;
  noise.baseline = 0.075;
  noise.grazing_angle = 1.4;
  noise.dropout = 0.01;
  measure(state, [&noise](Studio& studio) {
    std::vector<float> depth = studio.buffer.depth();
    add_noise(studio.camera, noise, 0, &depth);
    send(depth_image(studio.camera, depth));
  });
}

BENCHMARK(draw_only)->Unit(benchmark::kMillisecond);
BENCHMARK(depth)->Unit(benchmark::kMillisecond);
BENCHMARK(segmentation)->Unit(benchmark::kMillisecond);
BENCHMARK(points)->Unit(benchmark::kMillisecond);
BENCHMARK(noisy_depth)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bench
}  // namespace deformable_sim

BENCHMARK_MAIN();
