// The scenes in which contact is measured: sheets draped and crumpled, a rope in a knot, at any number of nodes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deformable_sim/core/world.h"

namespace deformable_sim {
namespace bench {

/// A collider that swings about its home while the scene runs.
struct Mover {
  std::string name;
  Pose home = Pose::Identity();
  Vec3 swing = Vec3::Zero();  // m
  double turn = 0.0;          // rad, about z
  double rate = 0.0;          // 1/s
  double stop = 1e9;          // s, when it stands still
};

/// A world and what happens to it from outside.
struct ContactScene {
  std::unique_ptr<World> world;
  std::vector<Mover> movers;
  double pull = 0.0;  // m/s, with which the grasps pin_rope_end_0 and pin_rope_end_1 go apart along x

  /// Gives the commands of the step to come.
  void command();
};

/// A sheet of 1 m, 0.2 kg/m^2, 1 kN/m and 2 mm thick, lying on 20 obstacles that swing (0.1 m/s): spheres, boxes,
/// capsules and three links of a robot, meshes that are not convex. It touches itself too.
ContactScene draped_sheet(int nodes);

/// The same sheet, dropped on a corner onto a plane between four walls that close in.
ContactScene crumpled_sheet(int nodes);

/// A rope of 8 mm, 5 mm a segment, whose two strands are wound about each other fifteen times half around along a ring
/// (the (2, 15) torus knot, cut open): every segment has a neighbour of the other strand. Its ends are drawn apart.
ContactScene knotted_rope(int segments);

}  // namespace bench
}  // namespace deformable_sim
