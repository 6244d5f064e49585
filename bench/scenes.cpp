#include "scenes.h"

#include <algorithm>
#include <cmath>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace bench {
namespace {

std::string cells(int nodes_x, int nodes_y) {
  return "cells: [" + std::to_string(nodes_x - 1) + ", " + std::to_string(nodes_y - 1) + "]";
}

const char* const kUpright =
    "pose: {position: [0, 0, 1.5], rpy: [1.5707963267948966, 0, 0]}, pins: [corner_2, corner_3]";

}  // namespace

std::string falling_towel() {
  return "bodies:\n"
         "  - cloth: {name: towel, size: [0.6, 0.45], " +
         cells(40, 30) +
         ", pose: {position: [0, 0, 0.1]}}\n"
         "colliders:\n"
         "  - box: {name: table, size: [0.5, 0.8, 0.1], pose: {position: [0, 0, -0.05]}}\n";
}

std::string hanging_towel() {
  return "bodies:\n"
         "  - cloth: {name: towel, size: [0.6, 0.45], " +
         cells(40, 30) + ", " + kUpright + "}\n";
}

std::string hanging_sheet(int side, Accuracy accuracy, double damping) {
  const std::string step = accuracy == Accuracy::kShipped ? "{}"
                                                          : "{dt: 0.05, linear_solver: direct, tolerance: 1.0e-6, "
                                                            "newton_iterations: 100}";
  return "step: " + step + "\nair: {damping: " + std::to_string(damping) + "}\nbodies:\n" +
         "  - cloth: {name: sheet, size: [1.0, 1.0], " + cells(side, side) + ", " + kUpright + "}\n";
}

std::string sheet_on_sphere(int side) {
  return "bodies:\n"
         "  - cloth: {name: sheet, size: [1.0, 1.0], " +
         cells(side, side) +
         ", pose: {position: [0, 0, 0.3]}}\n"
         "colliders:\n"
         "  - sphere: {name: ball, radius: 0.25}\n";
}

std::string rope(int nodes) {
  return "bodies:\n"
         "  - rope: {name: rope, length: 1.0, segments: " +
         std::to_string(nodes - 1) + ", pose: {position: [0, 0, 1]}, pins: [end_0]}\n";
}

std::unique_ptr<World> build(const std::string& text) {
  return build_world(load_scene_text(text, "bench"));
}

double max_strain(const World& world) {
  double largest = 0.0;
  for (const BodyReport& body : world.snapshot().bodies) largest = std::max(largest, body.max_strain);
  return largest;
}

double rms_speed(const World& world) {
  return std::sqrt(world.state().v.squaredNorm() / static_cast<double>(world.state().v.cols()));
}

}  // namespace bench
}  // namespace deformable_sim
