// What a world does with steps that cannot be right.
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "../../src/core/energy_book.h"
#include "support/small_worlds.h"

namespace deformable_sim {
namespace {

using test::at;
using test::grasp_nodes;

WorldSettings settings(const std::string& integrator, double dt = 0.01) {
  WorldSettings s;
  s.integrator = integrator;
  s.dt = dt;
  return s;
}

bool warns_of(const World& world, const std::string& what) {
  for (const std::string& warning : world.snapshot().warnings)
    if (warning.find(what) != std::string::npos) return true;
  return false;
}

/// A term of test points: nothing to bind, no pattern, no derivative.
class PlainTerm : public Energy {
 public:
  std::string name() const override { return "plain"; }
  int element_count() const override { return 1; }
  double value(const State&) const override { return 0.0; }
  void add_pattern(std::vector<std::array<int, 2>>*) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}
};

TEST(EnergyBook, KnowsFreeFallAndRefusesSpeedFromNowhere) {
  // K + V of a point in free fall is what it was; twice its speed is four times K.
  const auto model = test::points_model(Nodes::Zero(3, 1), 2.0, Vec3(0, 0, -10));
  Dynamics d;
  for (const auto& e : model->energies) d.energies.push_back(e.get());
  EnergyBook book;
  State s = model->initial;
  book.begin_step();
  book.end_step(*model, d, nullptr, s, 0.01, 1);
  s.x(2, 0) = -5.0;
  s.v(2, 0) = -10.0;
  EXPECT_NEAR(motion_energy(*model, s).kinetic, 100.0, 1e-12);
  EXPECT_NEAR(motion_energy(*model, s).weight, -100.0, 1e-12);
  EXPECT_TRUE(book.is_possible(*model, s));
  s.v *= 2.0;
  EXPECT_FALSE(book.is_possible(*model, s));
  book.add(300.0);  // of a hand that threw it
  EXPECT_TRUE(book.is_possible(*model, s));
  book.begin_step();
  book.add(1e6);
  book.restart_step();
  for (int k = 0; k < EnergyBook::kLookSteps; ++k) book.end_step(*model, d, nullptr, s, 0.01, 1);
  EXPECT_NEAR(book.created(), 0.0, 1e-9);
  s.v *= 2.0;
  for (int k = 0; k < EnergyBook::kLookSteps; ++k) book.end_step(*model, d, nullptr, s, 0.01, 1);
  EXPECT_NEAR(book.created(), 1200.0, 1e-9);
}

TEST(EnergyBook, KnowsWhatASoftGraspTookWithIt) {
  // 1 J moves beside 100 J in a spring that is let go: 40 J of motion then are 39 from nowhere.
  const auto model = test::points_model(Nodes::Zero(3, 1), 2.0, Vec3::Zero());
  const Dynamics d;
  EnergyBook book;
  State s = model->initial;
  s.v(0, 0) = 1.0;
  book.begin_step();
  book.end_step(*model, d, nullptr, s, 0.01, 1);
  book.change(100.0);
  State faster = s;
  faster.v(0, 0) = std::sqrt(40.0);
  book.begin_step();
  EXPECT_TRUE(book.is_possible(*model, faster));
  book.change(-100.0);
  book.begin_step();
  EXPECT_TRUE(book.is_possible(*model, s));
  EXPECT_FALSE(book.is_possible(*model, faster));
  for (int k = 0; k < EnergyBook::kLookSteps; ++k) book.end_step(*model, d, nullptr, faster, 0.01, 1);
  EXPECT_NEAR(book.created(), 39.0, 1e-9);
}

TEST(EnergyBook, SeesAGainThatIsSmallInEachStep) {
  // Kinetic energy grows by 17 % a step, below the quarter that a single one may swing by.
  const auto model = test::points_model(Nodes::Zero(3, 1), 2.0, Vec3::Zero());
  const Dynamics d;
  EnergyBook book;
  State s = model->initial;
  s.v(0, 0) = 10.0;
  book.begin_step();
  book.end_step(*model, d, nullptr, s, 0.01, 1);
  int steps = 0;
  while (steps < 10) {
    book.begin_step();
    s.v(0, 0) *= 1.08;
    if (book.has_gained(*model, d, nullptr, s, 0.25, 0.0)) break;
    book.end_step(*model, d, nullptr, s, 0.01, 1);
    ++steps;
  }
  EXPECT_EQ(steps,
            4);  // the first n with r^(n + 1) > 1 + (r^(n + 1) + r^n) / 4, r = 1.08^2: a gain of a half of the mean
}

TEST(EnergyBook, CountsForcesUntilALookAtAllEnergiesIsCheap) {
  const auto model = test::points_model(Nodes::Zero(3, 1), 2.0, Vec3::Zero());
  const Dynamics d;
  EnergyBook book;
  const State s = model->initial;
  EXPECT_TRUE(book.is_look_cheap(16));
  for (int k = 0; k < 3; ++k) {
    book.begin_step();
    EXPECT_FALSE(book.is_look_cheap(5));
    book.end_step(*model, d, nullptr, s, 0.01, 5);
  }
  book.begin_step();
  EXPECT_TRUE(book.is_look_cheap(5));  // 20 by now
  book.has_gained(*model, d, nullptr, s, 0.25, 0.0);
  book.end_step(*model, d, nullptr, s, 0.01, 5);
  EXPECT_FALSE(book.is_look_cheap(5));
}

TEST(EnergyBook, BalancesForceTimesWayOfAHeldNode) {
  // A point of 2 kg is held and carried 3 m up in 1 s: m g h = 60 J of work, none of it created.
  const auto model = test::points_model(Nodes::Zero(3, 2), 2.0, Vec3(0, 0, -10));
  for (const std::string scheme : {"implicit_euler", "tr_bdf2", "velocity_verlet", "substepped_verlet", "xpbd"}) {
    for (const double stiffness : {0.0, 2e3}) {
      command::Grasp hold{grasp_nodes("hand", "points", {0, 1})};
      hold.request.stiffness = stiffness;
      hold.request.max_speed = 10.0;
      if (stiffness > 0.0 && scheme == "xpbd") continue;
      World world(model, settings(scheme), {}, {});
      ASSERT_TRUE(world.apply(hold).status.ok());
      world.apply(command::MoveGrasp{"hand", at(0, 0, 3), 1.0});
      for (int k = 0; k < 120; ++k) ASSERT_TRUE(world.step().ok);
      EXPECT_NEAR(world.state().x(2, 0), 3.0, 0.4) << scheme;
      EXPECT_LT(world.snapshot().energy_created, 0.02 * 120.0) << scheme << " " << stiffness;
      EXPECT_EQ(world.snapshot().repeated, 0u) << scheme;
      EXPECT_FALSE(warns_of(world, "energy")) << scheme;
    }
  }
}

TEST(StepGuard, TellsOfEnergyFromNowhere) {
  // A term whose energy does not say what its force does: f = +c v drives a point at e^(c t / m).
  class Cheat : public PlainTerm {
   public:
    double value(const State&) const override { return 1e-30; }
    void add_force(const State& s, Nodes* f) const override { *f += 3.0 * s.v; }
  };
  for (const std::string scheme : {"implicit_euler", "rk4"}) {
    auto model = test::points_model(Nodes::Zero(3, 1), 1.0, Vec3::Zero());
    model->initial.v(0, 0) = 1.0;
    model->energies.push_back(std::make_unique<Cheat>());
    World world(model, settings(scheme), {}, {});
    for (int k = 0; k < 70; ++k) ASSERT_TRUE(world.step().ok);
    const double kinetic = 0.5 * world.state().v.squaredNorm();
    // All but what came since the last look: 16 steps of e^(0.06) each.
    EXPECT_GT(world.snapshot().energy_created, 0.3 * kinetic) << scheme;
    EXPECT_LT(world.snapshot().energy_created, kinetic) << scheme;
    EXPECT_TRUE(warns_of(world, "energy from nowhere")) << scheme;
    ASSERT_TRUE(world.apply(command::Reset{}).status.ok());
    EXPECT_EQ(world.snapshot().energy_created, 0.0);
  }
}

TEST(StepGuard, MakesAStepAgainWhoseEnergyIsImpossible) {
  // A kick in one force evaluation, gone when it is asked again.
  class Kick : public PlainTerm {
   public:
    void add_force(const State& s, Nodes* f) const override {
      if (s.time < 0.505 || kicked_) return;
      kicked_ = true;
      f->col(0) += Vec3(1000.0, 0, 0);
    }

   private:
    mutable bool kicked_ = false;
  };
  auto model = test::points_model(Nodes::Zero(3, 1), 1.0, Vec3::Zero());
  model->initial.v(0, 0) = 1.0;
  model->energies.push_back(std::make_unique<Kick>());
  World world(model, settings("symplectic_euler"), {}, {});
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world.step().ok);
  // What is known of the energy outlasts a hand that comes and goes.
  ASSERT_TRUE(world.apply(command::Grasp{grasp_nodes("hand", "points", {0})}).status.ok());
  ASSERT_TRUE(world.apply(command::Release{"hand"}).status.ok());
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(world.step().ok);
  EXPECT_NEAR(world.state().v(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(world.state().x(0, 0), 1.0, 1e-12);
  EXPECT_EQ(world.snapshot().repeated, 1u);
}

TEST(StepGuard, LetsOutWhatAColliderWasPutAround) {
  // 2 cm up: m g h = 0.8 J that nobody has put in.
  for (const std::string scheme : {"implicit_euler", "bdf2", "velocity_verlet", "xpbd"}) {
    World world(test::points_model(Nodes::Zero(3, 1), 4.0, Vec3(0, 0, -10)), settings(scheme),
                {test::collider("table", Shape::Type::kPlane, Vec3::Zero(), at(0, 0, -0.001))}, {});
    for (int k = 0; k < 50; ++k) ASSERT_TRUE(world.step().ok);
    world.apply(command::AddCollider{test::collider("box", Shape::Type::kBox, Vec3(1, 1, 0.1), at(0, 0, -0.03))});
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(world.step().ok);
    EXPECT_NEAR(world.state().x(2, 0), 0.02, 1e-4) << scheme;
    EXPECT_LE(world.snapshot().repeated, 10u) << scheme;
    EXPECT_LT(world.snapshot().energy_created, 0.9) << scheme;
  }
}

TEST(StepGuard, HasTheSafeSchemeMakeAStepThatTheOwnOneCannot) {
  // No number until somebody asks for its derivative, which explicit schemes never do.
  class Shy : public PlainTerm {
   public:
    explicit Shy(int node) : node_(node) {}
    void bind(const BlockMatrix&) override { bound_ = true; }
    void add_force(const State& s, Nodes* f) const override {
      if (!bound_ && s.time > 0.1) f->col(node_).setConstant(std::nan(""));
    }

   private:
    bool bound_ = false;
    int node_;
  };
  // A held node's force moves nothing, but a wrench is reported of it.
  for (const auto& [scheme, node] : std::vector<std::pair<std::string, int>>{
           {"velocity_verlet", 1}, {"substepped_verlet", 1}, {"velocity_verlet", 0}, {"substepped_verlet", 0}}) {
    auto model = test::points_model(Nodes::Zero(3, 2), 1.0, Vec3(0, 0, -10));
    model->energies.push_back(std::make_unique<Shy>(node));
    World world(model, settings(scheme), {}, {grasp_nodes("g", "points", {0})});
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(world.step().ok) << scheme;
    EXPECT_FALSE(warns_of(world, "implicit_euler made it"));
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(world.step().ok) << scheme;
    EXPECT_TRUE(warns_of(world, "implicit_euler made it")) << scheme;
    // Free fall, to the first order of one step in eight parts.
    EXPECT_NEAR(world.state().x(2, 1), -0.5 * 10 * 0.2 * 0.2, 10 * 0.2 * 0.01) << scheme;
    EXPECT_EQ(world.state().x(2, 0), 0.0);
    EXPECT_NEAR(world.grasp_reports()[0].force.z(), -10.0, 1e-6) << scheme;
    for (int k = 0; k < 105; ++k) ASSERT_TRUE(world.step().ok) << scheme;
    EXPECT_FALSE(warns_of(world, "implicit_euler made it")) << "told of for a second";
    EXPECT_NEAR(world.state().x(2, 1), -0.5 * 10 * 1.25 * 1.25, 10 * 1.25 * 0.01) << scheme;
  }
}

}  // namespace
}  // namespace deformable_sim
