// Commands from outside, between the steps of a scene made at random: lines of a scene file that begin with `#!`, which
// the loader takes for comments.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/world.h"

namespace deformable_sim::fuzz {

/// `#! TIME WORD [NAME ...] [NUMBER ...]`:
///
///   grasp NAME BODY node | radius | box  x y z  size max_force stiffness
///   move_grasp NAME  x y z  roll pitch yaw  duration
///   release NAME
///   add_collider NAME sphere | box | capsule | plane  x y z  size  friction
///   move_collider NAME  x y z  roll pitch yaw  duration
///   remove_collider NAME
///   set_state BODY  scale  dx dy dz  vx vy vz       places scaled about their mean and shifted, all at one velocity
///   scatter BODY  size seed                         places anywhere in a box
///   let_through COLLIDER BODY
///   reset
struct TimedCommand {
  double time = 0.0;  // s
  std::string word;
  std::vector<std::string> names;
  std::vector<double> numbers;
};

/// All of a file's text, in the order of their times. Throws InputError naming the line.
std::vector<TimedCommand> commands_of(const std::string& text);

/// What World::apply() says. Throws InputError where the line has too few names or numbers.
Reply apply(const TimedCommand& command, World* world);

}  // namespace deformable_sim::fuzz
