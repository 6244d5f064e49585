// What a headless run reports at its end, as text for people and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "deformable_sim/core/world.h"

namespace deformable_sim {

struct RunReport {
  std::string scene;
  std::string error;   // empty: the run reached its end
  std::string solver;  // what was chosen and why; empty: the scene names it
  Snapshot last;
  double cpu_seconds = 0.0;      // process CPU time of stepping
  double wall_seconds = 0.0;     // of stepping
  double max_penetration = 0.0;  // m, largest seen in the run
  double max_strain = 0.0;       // largest seen in the run, all bodies
  std::vector<BillItem> bill;

  /// Simulated over wall time; 0 before anything was measured.
  double real_time_factor() const { return wall_seconds > 0.0 ? last.time / wall_seconds : 0.0; }
};

/// A few lines.
std::string run_summary(const RunReport& report);

/// One object, on one line: scene, error, time, steps, dt, integrator, cpu_seconds, wall_seconds, real_time_factor,
/// solver, bodies {NAME: {nodes, max_strain, min_strain, energies {kinetic, elastic, potential}, bounds {min, max},
/// center_of_mass}}, grasps {NAME: {force, torque, state}}, max_penetration, max_strain, warnings, bill [{part, detail,
/// share}]. SI units. Numbers that are not finite become null.
std::string run_json(const RunReport& report);

}  // namespace deformable_sim
