// Stages of ropes in one walk: the same steps as with the generic terms and solver.
#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Dense>

#include "deformable_sim/core/integrator/rope_stage.h"
#include "deformable_sim/core/rope/rope_chain.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

struct Make {
  int nodes = 13;
  double axial = 1e4;      // N
  double bend = 0.0;       // N/m, springs over two links
  double rigidity = 1e-4;  // N m^2, line bending
  double damping = 0.0;    // s
  double drag = 0.3;       // 1/s
  bool soft = false;       // a spring to a target
  int second = 0;          // nodes of another rope behind it
  double rough = 1e-4;     // m, of the start
  double speed = 0.3;      // m/s
};

/// A rope along a wave in space, its first node held; uneven links.
class Rope : public System {
 public:
  explicit Rope(const Make& make) : Rope(make, line(make.nodes)) {}

  TargetSprings* target = nullptr;

 private:
  Rope(const Make& make, const Polyline& first) : System(all(make, first), masses(make, first)) {
    add_rope(make, first, 0);
    if (make.second > 0) add_rope(make, line(make.second), make.nodes);
    add_gravity();
    if (make.drag > 0.0) add(make_mass_damping(mass, make.drag));
    if (make.soft) {
      auto springs = std::make_unique<TargetSprings>(std::vector<int>{make.nodes - 2}, 30.0);
      springs->set_targets(state.x.col(make.nodes - 2) + Vec3(0.02, -0.01, 0.03));
      target = springs.get();
      add(std::move(springs));
    }
    hold(0);
    for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
      const auto s = static_cast<double>(i);
      state.x.col(i) += make.rough * Vec3(std::sin(2.0 * s), std::cos(1.3 * s), std::sin(0.7 * s));
      state.v.col(i) = make.speed * Vec3(std::sin(0.4 * s), std::cos(0.3 * s), std::sin(0.2 * s));
    }
    state.v.col(0).setZero();
    dynamics.kinematics.target.col(0) = state.x.col(0);
  }

  static Polyline line(int nodes) {
    Polyline line = make_line(0.05 * (nodes - 1), nodes - 1);
    for (Eigen::Index i = 0; i < nodes; ++i) {
      const double s = line.rest(0, i);
      line.rest.col(i) = Vec3(s + 0.1 * s * s, 0.05 * std::sin(3.0 * s), 0.04 * std::cos(4.0 * s));
    }
    return line;
  }
  static Nodes all(const Make& make, const Polyline& first) {
    Nodes x(3, make.nodes + make.second);
    x.leftCols(make.nodes) = first.rest;
    if (make.second > 0) x.rightCols(make.second) = line(make.second).rest;
    return x;
  }
  static Eigen::VectorXd masses(const Make& make, const Polyline& first) {
    Eigen::VectorXd mass(make.nodes + make.second);
    mass.head(make.nodes) = line_masses(first, 0.05);
    if (make.second > 0) mass.tail(make.second) = line_masses(line(make.second), 0.08);
    return mass;
  }
  void add_rope(const Make& make, const Polyline& line, int first_node) {
    LineStiffness stiffness;
    stiffness.axial = make.axial;
    stiffness.bend = make.bend;
    stiffness.damping_time = make.damping;
    const SpringNetwork network = line_network(line, stiffness);
    add(make_springs("stretch springs", network.stretch, first_node));
    if (make.bend > 0.0) add(make_springs("bend springs", network.bend, first_node));
    if (make.rigidity > 0.0) add(make_line_bending(line, make.rigidity, 0.5 * make.damping, first_node));
  }
};

SolverSettings settings(Jacobian jacobian) {
  SolverSettings s;
  s.linear = SolverSettings::Linear::kBanded;
  s.jacobian = jacobian;
  s.tolerance = 1e-8;
  s.newton_iterations = 60;
  return s;
}

/// Largest distance of nodes and difference of reactions to the same steps by ImplicitStage, solved as far.
struct Difference {
  double x = 0.0, v = 0.0, reaction = 0.0;
};
Difference difference_to_generic(const Make& make, const std::string& scheme, int steps) {
  Rope one(make), other(make);
  const auto rope = make_integrator(scheme, settings(Jacobian::kLagged));
  const auto generic = make_integrator(scheme, settings(Jacobian::kProjected));
  Difference d;
  for (int k = 0; k < steps; ++k) {
    for (Rope* r : {&one, &other}) r->dynamics.kinematics.target.col(0) += Vec3(2e-4, 1e-4, -1e-4);
    const StepReport a = one.step(*rope, 2e-3), b = other.step(*generic, 2e-3);
    EXPECT_TRUE(a.converged) << scheme << ", step " << k << ", " << a.residual;
    EXPECT_TRUE(b.converged) << scheme << ", step " << k << ", " << b.residual;
    if (make.damping == 0.0) {
      EXPECT_LT(a.newton_iterations, 16) << scheme;  // of two stages
    }
    d.x = std::max(d.x, (one.state.x - other.state.x).colwise().norm().maxCoeff());
    d.v = std::max(d.v, (one.state.v - other.state.v).colwise().norm().maxCoeff());
    d.reaction = std::max(d.reaction, (one.dynamics.kinematics.reaction - other.dynamics.kinematics.reaction).norm());
  }
  return d;
}

TEST(RopeStage, StepsAsTheGenericTermsDo) {
  // M a = f + more, solved by both to 1e-8 m/s^2: ten steps of tau^2 = 1e-6 s^2 differ by 1e-13 m and what rounding
  // adds, eps k / m tau^2 = 1e-12 m.
  for (const char* scheme : {"implicit_euler", "bdf2", "tr_bdf2"}) {
    for (const int nodes : {4, 5, 12, 13}) {
      for (const double bend : {0.0, 20.0}) {
        for (const double damping : {0.0, 2e-3}) {
          Make make;
          make.nodes = nodes;
          make.bend = bend;
          make.damping = damping;
          make.soft = nodes > 4;
          make.second = nodes == 13 ? 7 : 0;
          const Difference d = difference_to_generic(make, scheme, 10);
          EXPECT_LT(d.x, 2e-11) << scheme << " " << nodes << " " << bend << " " << damping;
          EXPECT_LT(d.v, 2e-8) << scheme << " " << nodes << " " << bend << " " << damping;
          EXPECT_LT(d.reaction, 2e-5) << scheme << " " << nodes << " " << bend << " " << damping;
        }
      }
    }
  }
}

TEST(RopeStage, StepsShortChainsToo) {
  // Of one, two and three nodes, without bending: places that no node fills do nothing.
  for (const int nodes : {1, 2, 3}) {
    Make make;
    make.nodes = 6;
    make.second = nodes;
    make.rigidity = 0.0;
    if (nodes == 1) {
      // A line needs a segment: a single node is one whose springs are missing.
      make.second = 0;
      make.nodes = 2;
    }
    const Difference d = difference_to_generic(make, "bdf2", 10);
    EXPECT_LT(d.x, 2e-11) << nodes;
  }
}

TEST(RopeStage, ConvergesQuadratically) {
  // The second matrix has the tension of the first move: what is left then is its square, whatever EA.
  for (const double axial : {1e3, 1e5, 1e7}) {
    Make make;
    make.axial = axial;
    make.nodes = 40;
    make.rough = make.speed = 0.0;
    Rope rope(make);
    SolverSettings s = settings(Jacobian::kLagged);
    s.tolerance = 1e-3;
    const auto integrator = make_integrator("bdf2", s);
    for (int k = 0; k < 20; ++k) {
      const StepReport report = rope.step(*integrator, 4e-3);
      EXPECT_TRUE(report.converged) << axial;
      EXPECT_LE(report.newton_iterations, 3) << axial << ", step " << k;
    }
  }
}

TEST(RopeStage, GivesTheSameOnEveryMachine) {
  // Only the rounding of fused multiplications differs: eps k / m tau^2 = 1e-12 m a step.
  Make make;
  make.bend = 20.0;
  make.damping = 1e-3;
  Rope plain(make), fused(make);
  setenv("DEFORMABLE_SIM_SIMD", "sse2", 1);
  const auto one = make_integrator("tr_bdf2", settings(Jacobian::kLagged));
  plain.step(*one, 2e-3);
  unsetenv("DEFORMABLE_SIM_SIMD");
  const auto other = make_integrator("tr_bdf2", settings(Jacobian::kLagged));
  fused.step(*other, 2e-3);
  EXPECT_LT((plain.state.x - fused.state.x).colwise().norm().maxCoeff(), 1e-11);
}

TEST(RopeStage, FindsTheTermsForce) {
  Make make;
  make.bend = 20.0;
  make.damping = 2e-3;
  make.soft = true;
  make.second = 6;
  Rope rope(make);
  rope.build_pattern();
  RopeStage stage(settings(Jacobian::kLagged));
  Nodes f;
  stage.find_force(rope.state, rope.dynamics, &f);
  const Nodes expected = rope.forces();
  EXPECT_LT((f - expected).norm(), 1e-10 * expected.norm());
}

TEST(RopeStage, LeavesARingToTheGenericTerms) {
  // Its last node is tied to its first: no chain, but the same steps.
  const int n = 12;
  Polyline ring = make_ring(0.6, n);
  LineStiffness stiffness;
  stiffness.axial = 1e3;
  stiffness.bend = 5.0;
  const auto make = [&] {
    auto body = std::make_unique<System>(ring.rest, line_masses(ring, 0.05));
    body->add_springs(line_network(ring, stiffness)).add_gravity().hold(0);
    return body;
  };
  auto one = make(), other = make();
  EXPECT_FALSE(find_chains(n, one->dynamics.energies).has_value());
  const auto lagged = make_integrator("bdf2", settings(Jacobian::kLagged));
  const auto projected = make_integrator("bdf2", settings(Jacobian::kProjected));
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(one->step(*lagged, 2e-3).converged);
    other->step(*projected, 2e-3);
  }
  EXPECT_LT((one->state.x - other->state.x).norm(), 1e-9);
}

TEST(RopeStage, MeetsAFloorWithTheGenericTerms) {
  // While a contact is named the generic terms do the step, before and after it the rope: it comes to rest on the
  // floor, which carries its weight.
  Make make;
  make.nodes = 8;
  make.axial = 1e3;
  make.drag = 5.0;
  Rope rope(make);
  rope.dynamics.kinematics.node.clear();
  rope.dynamics.kinematics.target.resize(3, 0);
  SolverSettings s = settings(Jacobian::kLagged);
  s.tolerance = 1e-4;
  const auto integrator = make_integrator("bdf2", s);
  std::vector<std::array<int, 2>> none;
  rope.build_pattern(none);
  double weight = 0.0;
  for (int k = 0; k < 1500; ++k) {
    rope.dynamics.contacts.clear();
    for (int i = 0; i < 8; ++i) {
      if (rope.state.x(2, i) > -0.2 + 0.02) continue;
      ContactConstraint c;
      c.node[0] = i;
      c.offset = -0.2;
      c.friction = 0.5;
      rope.dynamics.contacts.push_back(c);
    }
    rope.step(*integrator, 2e-3);
    weight = 0.0;
    for (const ContactConstraint& c : rope.dynamics.contacts) weight += c.force.z();
  }
  EXPECT_NEAR(weight, kGravity * rope.mass.sum(), 0.02 * kGravity * rope.mass.sum());
  EXPECT_GT(rope.state.x.row(2).minCoeff(), -0.2 - 1e-4);
}

TEST(RopeChains, AreFoundWhereLinesLieSideBySide) {
  Make make;
  make.nodes = 9;
  make.second = 5;
  make.bend = 20.0;
  Rope rope(make);
  const auto chains = find_chains(14, rope.dynamics.energies);
  ASSERT_TRUE(chains.has_value());
  ASSERT_EQ(chains->size(), 2u);
  EXPECT_EQ((*chains)[1].first_node, 9);
  EXPECT_EQ((*chains)[1].count, 5);
  EXPECT_FALSE((*chains)[0].spans.empty());
}

}  // namespace
}  // namespace deformable_sim::test
