// A world stepped through an extreme case, watched by what has to hold in every one of them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/core/world.h"
#include "support/verification.h"

namespace deformable_sim::test {

struct Watched {
  int steps = 0;
  int unsolved = 0;          // steps whose residual stayed above the solver's tolerance, and that say so
  double misreported = 0.0;  // largest difference of a reported residual from that of the states, relative
  double gain = 0.0;         // largest rise of the energy in a step, over the most there was
  double momentum = 0.0;     // largest |sum m v| over the largest sum m |v|
  double furthest = 0.0;     // m from the origin
};

/// J, motion, springs and weight of all bodies.
inline double total_energy(const World& world) {
  double sum = 0.0;
  for (const BodyReport& b : world.snapshot().bodies) sum += b.kinetic_energy + b.elastic_energy + b.potential_energy;
  return sum;
}

/// RMS of (v1 - v0) / dt - f(x1, v1) / m, m/s^2: what a step of implicit Euler leaves, from the states alone. For
/// worlds without contacts and held nodes.
inline double implicit_euler_residual(const Model& model, const State& before, const State& after, double dt) {
  Nodes f = Nodes::Zero(3, after.x.cols());
  for (const auto& energy : model.energies) energy->add_force(after, &f);
  const Nodes left = (after.v - before.v) / dt - f * model.mass.cwiseInverse().asDiagonal();
  return std::sqrt(left.squaredNorm() / static_cast<double>(left.cols()));
}

/// Steps for so many seconds; fails where a step has no end, is not finite or keeps its residual to itself: where it
/// calls itself solved the residual has to be below the tolerance, where not above. No held nodes, no contacts.
inline Watched watch(World* world, double seconds) {
  Watched found;
  const double tolerance = world->settings().solver.tolerance, dt = world->settings().dt;
  double energy = total_energy(*world), most = std::abs(energy), motion = 0.0, momentum = 0.0;
  const double end = world->time() + seconds - 0.5 * dt;
  while (world->time() < end) {
    const State before = world->state();
    const StepOutcome outcome = world->step();
    ++found.steps;
    EXPECT_TRUE(outcome.ok) << outcome.message;
    EXPECT_TRUE(world->state().finite());
    if (!outcome.ok) return found;
    const StepReport& report = outcome.report;
    EXPECT_EQ(report.converged, report.residual <= tolerance) << report.residual << " at " << world->time();
    if (!report.converged) ++found.unsolved;
    if (world->settings().integrator == "implicit_euler" && world->snapshot(SnapshotDetail::kMotion).substeps == 1) {
      const double left = implicit_euler_residual(world->model(), before, world->state(), dt);
      found.misreported = std::max(found.misreported, std::abs(left - report.residual) / std::max(left, tolerance));
    }
    const Nodes& v = world->state().v;
    motion = std::max(motion, v.colwise().norm().dot(world->model().mass));
    momentum = std::max(momentum, (v * world->model().mass).norm());
    const double now = total_energy(*world);
    most = std::max(most, now);
    found.gain = std::max(found.gain, (now - energy) / most);
    energy = now;
    found.furthest = std::max(found.furthest, world->state().x.colwise().norm().maxCoeff());
  }
  if (motion > 0.0) found.momentum = momentum / motion;
  return found;
}

/// What holds in all of them, as rows of the report; `reach`: m, how far anything may get.
inline void check_watched(const std::string& row, const std::string& what, const Watched& found, double reach) {
  check(row, what + ": rise of the energy in a step, over all there is", found.gain, 0.0, 1e-6, Tolerance::kAbsolute);
  check(row, what + ": momentum made, over that of the parts", found.momentum, 0.0, 1e-10, Tolerance::kAbsolute);
  check(row, what + ": reported residual against that of the states", found.misreported, 0.0, 1e-6,
        Tolerance::kAbsolute);
  EXPECT_LT(found.furthest, reach) << row << ", " << what;
}

}  // namespace deformable_sim::test
