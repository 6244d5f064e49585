// A world stepped through an extreme case, watched by what has to hold in every one of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "deformable_sim/core/world.h"
#include "support/verification.h"

namespace deformable_sim::test {

struct Watched {
  int steps = 0;
  int unsolved = 0;          // steps whose residual stayed above the solver's tolerance, and that say so
  double misreported = 0.0;  // largest difference of a reported residual from that of the states, relative
  double gain = 0.0;         // largest rise of the energy in a step, over the most that moved, was stored or fell
  double momentum = 0.0;     // largest |sum m v| over the largest sum m |v|
  double furthest = 0.0;     // m from the origin
};

struct Watching {
  std::vector<int> held;   // nodes that stay where they are
  double round_off = 0.0;  // J, of the stored energy
};

struct Energies {
  double kinetic = 0.0, elastic = 0.0, weight = 0.0;  // J
  double sum() const { return kinetic + elastic + weight; }
};

inline Energies energies_of(const World& world) {
  Energies sum;
  for (const BodyReport& b : world.snapshot().bodies) {
    sum.kinetic += b.kinetic_energy;
    sum.elastic += b.elastic_energy;
    sum.weight += b.potential_energy;
  }
  return sum;
}

/// RMS over free nodes of (v1 - v0) / dt - f(x1, v1) / m, m/s^2: what a step of implicit Euler leaves, from the states
/// alone. For worlds without contacts.
inline double implicit_euler_residual(const Model& model, const State& before, const State& after, double dt,
                                      const std::vector<int>& held) {
  Nodes f = Nodes::Zero(3, after.x.cols());
  for (const auto& energy : model.energies) energy->add_force(after, &f);
  Nodes left = (after.v - before.v) / dt - f * model.mass.cwiseInverse().asDiagonal();
  for (const int node : held) left.col(node).setZero();
  return std::sqrt(left.squaredNorm() / static_cast<double>(left.cols() - static_cast<Eigen::Index>(held.size())));
}

/// A step tells how well it is solved: solved means a residual below the tolerance, and no other; far above it there is
/// a warning, too.
inline void expect_reported(const World& world, const StepReport& report) {
  EXPECT_EQ(report.converged, report.residual <= world.settings().solver.tolerance) << report.residual;
  if (report.converged || report.residual <= 20.0) return;
  const std::vector<std::string> warnings = world.snapshot().warnings;
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& w) {
    return w.find("the step is inaccurate") != std::string::npos;
  })) << report.residual;
}

/// Steps for so many seconds; fails where a step has no end, is not finite or keeps its residual to itself. No
/// contacts.
inline Watched watch(World* world, double seconds, const Watching& watching = {}) {
  Watched found;
  const double tolerance = world->settings().solver.tolerance, dt = world->settings().dt;
  const Energies start = energies_of(*world);
  double energy = start.sum(), moved = start.elastic, motion = 0.0, momentum = 0.0, rise = 0.0;
  const double end = world->time() + seconds - 0.5 * dt;
  while (world->time() < end) {
    const State before = world->state();
    const StepOutcome outcome = world->step();
    ++found.steps;
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_TRUE(world->state().finite());
    if (!outcome.ok) return found;
    expect_reported(*world, outcome.report);
    if (!outcome.report.converged) ++found.unsolved;
    if (world->settings().integrator == "implicit_euler" && world->snapshot(SnapshotDetail::kMotion).substeps == 1) {
      const double left = implicit_euler_residual(world->model(), before, world->state(), dt, watching.held);
      found.misreported =
          std::max(found.misreported, std::abs(left - outcome.report.residual) / std::max(left, tolerance));
    }
    const Nodes& v = world->state().v;
    motion = std::max(motion, v.colwise().norm().dot(world->model().mass));
    momentum = std::max(momentum, (v * world->model().mass).norm());
    const Energies now = energies_of(*world);
    moved = std::max(moved, now.kinetic + now.elastic + std::abs(now.weight - start.weight));
    rise = std::max(rise, now.sum() - energy - watching.round_off);
    energy = now.sum();
    found.furthest = std::max(found.furthest, world->state().x.colwise().norm().maxCoeff());
  }
  if (moved > 0.0) found.gain = rise / moved;
  if (motion > 0.0) found.momentum = momentum / motion;
  return found;
}

/// What holds in all of them that are free, as rows of the report; `reach`: m, how far anything may get.
inline void check_watched(const std::string& row, const std::string& what, const Watched& found, double reach) {
  check(row, what + ": rise of the energy in a step, over all there is", found.gain, 0.0, 1e-6, Tolerance::kAbsolute);
  check(row, what + ": momentum made, over that of the parts", found.momentum, 0.0, 1e-10, Tolerance::kAbsolute);
  check(row, what + ": reported residual against that of the states", found.misreported, 0.0, 1e-6,
        Tolerance::kAbsolute);
  EXPECT_LT(found.furthest, reach) << row << ", " << what;
}

}  // namespace deformable_sim::test
