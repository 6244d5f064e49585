// The scenes that are measured, as text, in one place.
#pragma once

#include <memory>
#include <string>

#include "deformable_sim/core/world.h"

namespace deformable_sim {
namespace bench {

/// How carefully each step is solved.
enum class Accuracy {
  kShipped,    // dt 10 ms, the solver settings that a scene gets when it names none
  kConverged,  // dt 50 ms, sparse direct, RMS unbalanced acceleration below 1e-6 m/s^2: the reference
};

/// Cotton towel of 0.6 m x 0.45 m, 40 x 30 nodes: falling flat onto a table, or hanging from two corners.
std::string falling_towel();
std::string hanging_towel();

/// Square cotton sheet of 1 m, side x side nodes, hanging from two corners; damped (1/s) so that it comes to rest.
std::string hanging_sheet(int side, Accuracy accuracy, double damping);

/// Square cotton sheet of 1 m, side x side nodes, dropped on a ball of radius 0.25 m.
std::string sheet_on_sphere(int side);

/// Rope of 1 m that starts level, held at one end, and swings down.
std::string rope(int nodes);

/// A world built from scene text; throws InputError.
std::unique_ptr<World> build(const std::string& text);

/// Largest structural strain over the bodies.
double max_strain(const World& world);

/// Root mean square speed of the nodes, m/s.
double rms_speed(const World& world);

}  // namespace bench
}  // namespace deformable_sim
