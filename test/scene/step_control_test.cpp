// Steps in as many parts as an error asks for, or a budget allows.
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "deformable_sim/core/error.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

std::unique_ptr<World> rope(const std::string& step) {
  return build_world(load_scene_text("step: " + step +
                                         "\nair: {damping: 1}\nbodies:\n  - rope: {name: rope, length: 1.0, segments: "
                                         "12, material: {axial_stiffness: 50, linear_density: 0.05}, pins: [end_0]}\n",
                                     "test"));
}

Nodes after_a_second(World* world) {
  while (world->time() < 1.0 - 1e-9) EXPECT_TRUE(world->step().ok);
  return world->state().x;
}

/// RMS relative to the rope's length.
double difference(const Nodes& a, const Nodes& b) {
  return (a - b).norm() / std::sqrt(static_cast<double>(a.cols()));
}

bool warns_of(const World& world, const std::string& what) {
  for (const std::string& warning : world.snapshot().warnings)
    if (warning.find(what) != std::string::npos) return true;
  return false;
}

TEST(StepControl, HoldsTheErrorThatIsAskedFor) {
  // Against the same rope in steps of 20 us. The estimate adds errors up, so it may be held too well: by 30 at most.
  const Nodes exact = after_a_second(rope("{integrator: rk4, dt: 2.0e-5}").get());
  for (const std::string scheme : {"implicit_euler", "implicit_midpoint", "tr_bdf2", "bdf2"}) {
    double last = 1.0;
    for (const double accuracy : {0.03, 0.01, 0.003}) {
      const std::unique_ptr<World> world = rope("{integrator: " + scheme +
                                                ", dt: 0.02, newton_iterations: 50, tolerance: 1.0e-6, control: error, "
                                                "accuracy: " +
                                                std::to_string(accuracy) + "}");
      const double error = difference(after_a_second(world.get()), exact);
      // A scheme of first order would need more parts than there are, and says so.
      const bool beyond = scheme == "implicit_euler" && accuracy == 0.003;
      EXPECT_EQ(warns_of(*world, "are asked for"), beyond) << scheme << " " << accuracy;
      EXPECT_LT(error, (beyond ? 2.0 : 1.0) * accuracy) << scheme;
      EXPECT_GT(error, accuracy / 100.0) << scheme;
      EXPECT_LT(error, last) << scheme;
      last = error;
    }
  }
}

TEST(StepControl, SaysWhenMorePartsThanThereAreWouldBeNeeded) {
  const std::unique_ptr<World> world = rope("{integrator: implicit_euler, dt: 0.1, control: error, accuracy: 1.0e-5}");
  after_a_second(world.get());
  EXPECT_EQ(world->snapshot().substeps, 64);
  EXPECT_TRUE(warns_of(*world, "0.001 % are asked for: steps in 64 parts are the most there are"));
}

TEST(StepControl, GivesTheSameBitsAgain) {
  const std::string step = "{integrator: bdf2, dt: 0.01, control: error, accuracy: 0.003}";
  EXPECT_EQ(after_a_second(rope(step).get()), after_a_second(rope(step).get()));
}

TEST(StepControl, KeepsToABudgetAndSaysWhatItCosts) {
  // Nothing is done in a microsecond a second: one part a step, and a word on both the budget and the error.
  const std::unique_ptr<World> poor =
      rope("{integrator: implicit_euler, dt: 0.02, control: budget, accuracy: 0.001, budget: 1.0e-6}");
  after_a_second(poor.get());
  EXPECT_LE(poor->snapshot().substeps, 2);  // the last step may have been made twice
  EXPECT_TRUE(warns_of(*poor, "the budget of 1e-06 CPU s per simulated s is not held"));
  // Nor is the floor passed for it: then the budget is not held.
  const std::unique_ptr<World> floored = rope(
      "{integrator: implicit_euler, dt: 0.02, control: budget, accuracy: 0.001, budget: 1.0e-6, accuracy_floor: 0.02}");
  after_a_second(floored.get());
  EXPECT_GT(floored->snapshot().substeps, 2);
  EXPECT_LT(floored->snapshot().substeps, 64);
  EXPECT_TRUE(warns_of(*floored, "the error may be 2 % a second at most"));
  // With all the time in the world the error decides.
  const std::unique_ptr<World> rich =
      rope("{integrator: implicit_euler, dt: 0.02, control: budget, accuracy: 0.01, budget: 1000}");
  after_a_second(rich.get());
  EXPECT_GT(rich->snapshot().substeps, 1);
  EXPECT_FALSE(warns_of(*rich, "budget"));
}

TEST(StepControl, IsPartOfTheScene) {
  const auto control_of = [](const std::string& step) {
    return build_world(load_scene_text("step: " + step + "\nbodies:\n  - rope: {name: rope}\n", "test"))
        ->settings()
        .control;
  };
  EXPECT_EQ(control_of("auto").control, StepControl::kError);
  EXPECT_EQ(control_of("{dt: 0.01}").control, StepControl::kFixed);
  EXPECT_EQ(control_of("{control: budget, budget: 0.3, accuracy: reference, integrator: bdf2}").budget, 0.3);
  EXPECT_EQ(control_of("{control: error, accuracy: reference}").error, 0.001);
  for (const auto& [step, refusal] : {std::pair<std::string, std::string>{"sometimes", "auto"},
                                      {"{control: perhaps}", "fixed, error, budget"},
                                      {"{control: error, budget: 0.3, integrator: bdf2}", "step.budget: belongs to"},
                                      {"{control: error, accuracy_floor: 0.3}", "step.accuracy_floor: belongs to"}}) {
    try {
      control_of(step);
      ADD_FAILURE() << step;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(refusal), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace deformable_sim
