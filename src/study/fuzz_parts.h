// The parts of a scene made at random, shared by the files that draw them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "fuzz_random.h"
#include "fuzz_scene.h"

namespace deformable_sim::fuzz {

/// What the rest of a scene has to know of a body.
struct DrawnBody {
  std::string name, kind;             // cloth, rope or soft
  std::vector<std::string> features;  // that share no node
  std::array<double, 3> center{};     // m, at the start
  bool springs_only = false;          // and constant bending: what the dual schemes take
  bool consistent_mass = false;
  int nodes = 0;
};

struct Drawing {
  Random random;
  double size = 0.4;  // m, of a body, about
  std::vector<DrawnBody> bodies;
  std::vector<std::string> colliders, grasps;
  double motion_ends = 0.6;  // s: after it nothing is commanded
  Case result;

  explicit Drawing(std::uint64_t seed) : random(seed) {}

  /// A place within `reach` sizes of the middle of the scene.
  std::array<double, 3> place(double reach);
  std::array<double, 3> turn();
  /// {position, rpy}; turned in a part of the cases.
  Tree pose(const std::array<double, 3>& position, double turned);
};

/// Adds to scene.bodies; at most so many nodes.
void draw_cloth(Drawing* d, int most_nodes);
void draw_rope(Drawing* d, int most_nodes);
void draw_soft(Drawing* d, int most_nodes);
/// What all bodies have: name, pose, friction, contact radius, touches, pins.
void draw_common(Drawing* d, DrawnBody body, Tree* map);

void draw_colliders(Drawing* d);
void draw_grasps(Drawing* d);
void draw_script(Drawing* d);
void draw_commands(Drawing* d);
void draw_air(Drawing* d);
void draw_step(Drawing* d);

}  // namespace deformable_sim::fuzz
