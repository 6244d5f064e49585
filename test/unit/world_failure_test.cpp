// Steps of a World that fail.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::collider;
using test::grasp_nodes;

WorldSettings settings(const std::string& integrator = "implicit_euler", double dt = 0.01) {
  WorldSettings s;
  s.integrator = integrator;
  s.dt = dt;
  return s;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(World, StaysAtItsLastGoodStateWhenThereIsNoFiniteStep) {
  // A term whose force is not a number makes every step fail; what is shown stays finite and time stands still.
  class NotANumber : public Energy {
   public:
    explicit NotANumber(double from) : from_(from) {}
    std::string name() const override { return "not a number"; }
    int element_count() const override { return 1; }
    double value(const State&) const override { return 0.0; }
    void add_force(const State& s, Nodes* f) const override {
      if (s.time > from_) f->col(0).setConstant(std::nan(""));
    }
    void add_pattern(std::vector<std::array<int, 2>>*) const override {}
    void bind(const BlockMatrix&) override {}
    void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}

   private:
    double from_;
  };
  for (const std::string& scheme : integrator_names()) {
    auto model = test::points_model(Nodes::Zero(3, 1), 0.1, Vec3(0, 0, -9.81));
    model->energies.push_back(std::make_unique<NotANumber>(0.055));
    World world(model, settings(scheme), {collider("floor", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, -1))}, {});
    StepOutcome outcome;
    int steps = 0;
    while (outcome.ok && steps < 20) {
      outcome = world.step();
      ++steps;
    }
    ASSERT_FALSE(outcome.ok) << scheme;
    EXPECT_TRUE(contains(outcome.message, "no finite state")) << outcome.message;
    EXPECT_NEAR(world.time(), 0.01 * (steps - 1), 1e-12);
    EXPECT_TRUE(world.state().finite());
    const State stopped = world.state();
    EXPECT_FALSE(world.step().ok);
    EXPECT_TRUE(test::same_state(world.state(), stopped));
    const Snapshot s = world.snapshot();
    EXPECT_TRUE(s.x.allFinite());
    EXPECT_TRUE(std::isfinite(s.report.residual));
    EXPECT_FALSE(s.warnings.empty());
    ASSERT_TRUE(world.apply(command::Reset{}).status.ok());
    EXPECT_TRUE(world.step().ok);
  }
}

TEST(World, StartsAFailedStepAgainFromWhereItWas) {
  // A force that is no number once makes one attempt fail; the repeated step moves grasp, collider and clock only once.
  class FailsOnce : public Energy {
   public:
    std::string name() const override { return "fails once"; }
    int element_count() const override { return 1; }
    double value(const State&) const override { return 0.0; }
    void add_force(const State& s, Nodes* f) const override {
      if (s.time < 0.045 || failed_) return;
      failed_ = true;
      f->col(1).setConstant(std::nan(""));
    }
    void add_pattern(std::vector<std::array<int, 2>>*) const override {}
    void bind(const BlockMatrix&) override {}
    void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}

   private:
    mutable bool failed_ = false;
  };
  for (const std::string scheme : {"symplectic_euler", "velocity_verlet", "rk4"}) {
    auto model = test::points_model(Nodes::Zero(3, 2), 0.1, Vec3::Zero());
    model->initial.v(0, 1) = 0.5;
    model->energies.push_back(std::make_unique<FailsOnce>());
    World world(model, settings(scheme), {collider("far", Shape::Type::kBox, Vec3(1, 1, 1), at(0, 0, -5))},
                {grasp_nodes("g", "points", {0})});
    world.apply(command::MoveGrasp{"g", at(0.1, 0, 0), 0.1});
    world.apply(command::MoveCollider{"far", at(0, 0.1, -5), 0.1});
    int most_parts = 1;
    for (int i = 0; i < 7; ++i) {
      ASSERT_TRUE(world.step().ok) << scheme;
      most_parts = std::max(most_parts, world.snapshot().substeps);
    }
    EXPECT_EQ(most_parts, 2) << scheme;
    const Snapshot s = world.snapshot();
    EXPECT_NEAR(s.x(0, 0), 0.07, 1e-12) << scheme;
    EXPECT_NEAR(s.x(0, 1), 0.035, 1e-9) << scheme;
    EXPECT_NEAR(s.colliders[0].world_from_collider.translation().y(), 0.07, 1e-12) << scheme;
    EXPECT_NEAR(s.time, 0.07, 1e-12);
  }
}

}  // namespace
}  // namespace deformable_sim
