// The families whose unknowns are tensions, and projective dynamics: what they solve exactly, what they say of the
// rest, and what they refuse.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/error.h"
#include "deformable_sim/core/world.h"
#include "support/slope.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

SolverSettings sweeps(int count, SolverSettings::Precision precision = SolverSettings::Precision::kDouble) {
  SolverSettings settings;
  settings.newton_iterations = count;
  settings.tolerance = 1e-11;
  settings.precision = precision;
  return settings;
}

constexpr int kLinks = 12;
constexpr double kMass = 0.02;  // of a node, kg

/// A chain under its weight, hung by its first node, where its closed form says: link i carries the nodes below it,
/// k (r - L) = (n - i) m g.
std::unique_ptr<System> hanging_chain(double stiffness) {
  Nodes x = Nodes::Zero(3, kLinks + 1);
  std::vector<SpringLink> links;
  for (int i = 0; i < kLinks; ++i) {
    x(2, i + 1) = x(2, i) - 0.05 - (kLinks - i) * kMass * kGravity / stiffness;
    links.push_back({i, i + 1, 0.05, stiffness, 0.0});
  }
  auto chain = std::make_unique<System>(x, Eigen::VectorXd::Constant(kLinks + 1, kMass));
  chain->add(make_springs("chain", links, 0)).add_gravity().hold(0);
  return chain;
}

TEST(HangingChain, OfOneLineIsSolvedExactlyWhateverItsStiffness) {
  // One tridiagonal system is the whole step: nothing is left unbalanced and nothing moves.
  for (const double stiffness : {1e2, 1e4, 1e7}) {
    auto chain = hanging_chain(stiffness);
    const Nodes rest = chain->state.x;
    const auto integrator = make_integrator("line_dual", sweeps(1));
    for (int k = 0; k < 100; ++k) {
      // Positions are known to 1e-16 m, spring forces to that times k.
      EXPECT_LT(chain->step(*integrator, 5e-3).residual, 1e-15 * stiffness / kMass + 1e-9);
    }
    EXPECT_LT((chain->state.x - rest).cwiseAbs().maxCoeff(), 1e-12) << stiffness;
    EXPECT_NEAR(chain->dynamics.kinematics.reaction(2, 0), (kLinks + 1) * kMass * kGravity, 1e-8);
  }
}

TEST(HangingChain, FallsToItsClosedForm) {
  // Started unstretched, with drag: sum of (n - i) m g / k below the holder.
  const double stiffness = 200.0;
  auto chain = hanging_chain(stiffness);
  const Nodes rest = chain->state.x;
  for (int i = 0; i <= kLinks; ++i) chain->state.x(2, i) = -0.05 * i;
  chain->add(make_mass_damping(chain->mass, 20.0));
  const auto integrator = make_integrator("line_dual", sweeps(1));
  for (int k = 0; k < 4000; ++k) chain->step(*integrator, 5e-3);
  EXPECT_LT((chain->state.x - rest).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(HangingChain, IsStretchedByWhatXpbdLeavesUndoneAsItsResidualSays) {
  // One spring after the other, once: gravity's g dt^2 a step is not all undone. Second order in the step, and
  // reported.
  std::vector<double> steps, errors;
  for (const double dt : {4e-3, 2e-3, 1e-3}) {
    auto chain = hanging_chain(5e3);
    chain->add(make_mass_damping(chain->mass, 20.0));
    const Nodes rest = chain->state.x;
    const auto integrator = make_integrator("xpbd", sweeps(1));
    StepReport report;
    for (int k = 0; k < 2.0 / dt; ++k) report = chain->step(*integrator, dt);
    steps.push_back(dt);
    errors.push_back((chain->state.x - rest).norm());
    EXPECT_FALSE(report.converged);
    EXPECT_GT(report.residual, 5e3 / kMass * errors.back() / 1e3);
  }
  EXPECT_GT(errors.back(), 1e-6);
  EXPECT_GT(log_slope(steps, errors), 1.5);
}

TEST(HangingChain, StaysAtRestInProjectiveDynamicsWithOneIteration) {
  auto chain = hanging_chain(1e5);
  const Nodes rest = chain->state.x;
  const auto integrator = make_integrator("projective_dynamics", sweeps(1));
  for (int k = 0; k < 100; ++k) chain->step(*integrator, 5e-3);
  EXPECT_LT((chain->state.x - rest).cwiseAbs().maxCoeff(), 1e-10);
}

/// A sheet of 9 x 7 cells with bending and dampers, as terms and, if `rows`, as a grid, hung by two nodes.
struct Sheet {
  explicit Sheet(bool rows, double membrane = 200.0, double damping_time = 1e-3) {
    mesh = make_grid(0.5, 0.4, 9, 7);
    SheetStiffness stiffness;
    stiffness.membrane = membrane;
    stiffness.damping_time = damping_time;
    const SpringNetwork network = sheet_network(mesh, stiffness);
    const std::vector<QuadraticWeight> weights = grid_bending_weights(mesh, isotropic_bending(1e-4, 0.3));
    body = std::make_unique<System>(mesh.rest, sheet_masses(mesh, 0.2));
    body->add_springs(network).add(make_quadratic_links("bending", weights, 1e-2, 0));
    if (rows) {
      grids.push_back(*make_grid_sheet(mesh, network, weights, 1e-2, 0));
      grids[0].replaces = body->dynamics.energies;
      body->dynamics.grids = &grids;
    }
    body->add_gravity().add(make_mass_damping(body->mass, 1.0)).hold(0).hold(9);
  }
  TriangleMesh mesh;
  std::vector<GridSheet> grids;
  std::unique_ptr<System> body;
};

/// Where a sheet is after 0.1 s.
Nodes fallen(const std::string& scheme, const SolverSettings& settings, double dt, bool rows) {
  Sheet sheet(rows);
  const auto integrator = make_integrator(scheme, settings);
  for (int k = 0; k < std::lround(0.1 / dt); ++k) sheet.body->step(*integrator, dt);
  EXPECT_GT((sheet.body->state.x - sheet.mesh.rest).norm(), 0.1);
  return sheet.body->state.x;
}

TEST(DualSheet, IsTheSameInRowsAndAsChainsButForTheTurningOfItsSprings) {
  // Two orders of Gauss-Seidel swept to the end. Each leaves its springs' forces where they pointed when they were
  // solved, which differs by what they turn in a step: towards
  // second order.
  std::vector<double> steps, differences;
  for (const double dt : {5e-3, 2.5e-3, 1.25e-3}) {
    steps.push_back(dt);
    differences.push_back(
        (fallen("line_dual", sweeps(100), dt, true) - fallen("line_dual", sweeps(100), dt, false)).norm());
  }
  EXPECT_LT(differences.front(), 2e-3);
  EXPECT_GT(log_slope(steps, differences), 1.6);
}

TEST(DualSheet, IsImplicitEulersWhenIteratedToTheEnd) {
  // Projective dynamics solves the equations of implicit Euler; XPBD does but for the turning of its springs.
  for (const bool rows : {false, true}) {
    std::vector<double> steps, differences;
    for (const double dt : {5e-3, 2.5e-3}) {
      const Nodes exact = fallen("implicit_euler", exact_settings(1e-10), dt, rows);
      EXPECT_LT((fallen("projective_dynamics", sweeps(600), dt, rows) - exact).cwiseAbs().maxCoeff(), 1e-8) << rows;
      steps.push_back(dt);
      differences.push_back((fallen("xpbd", sweeps(100), dt, rows) - exact).norm());
    }
    EXPECT_LT(differences.front(), 2e-3);
    EXPECT_GT(log_slope(steps, differences), 1.6) << rows;
  }
}

TEST(DualSheet, ReportsWhatIsTrulyUnbalanced) {
  // RMS of f / m - a over the free nodes, the forces those of the terms at the end of the step.
  for (const char* name : {"line_dual", "xpbd", "projective_dynamics"}) {
    for (const bool rows : {false, true}) {
      Sheet sheet(rows);
      System& body = *sheet.body;
      const auto integrator = make_integrator(name, sweeps(1));
      const double dt = 5e-3;
      for (int k = 0; k < 10; ++k) body.step(*integrator, dt);
      const State before = body.state;
      const double reported = body.step(*integrator, dt).residual;
      // BDF2 of steps that are alike: a = (3 v - 4 v0 + v1) / (2 dt).
      const bool two_steps = std::string(name) == "line_dual";
      const Nodes f = body.forces();
      double sum = 0.0;
      for (Eigen::Index i = 0; i < f.cols(); ++i) {
        if (i == 0 || i == 9) continue;
        const Vec3 v = body.state.v.col(i), v0 = before.v.col(i);
        const Vec3 a = two_steps ? Vec3((1.5 * v - 2.0 * v0 + 0.5 * before.v_before.col(i)) / dt) : Vec3((v - v0) / dt);
        sum += (f.col(i) / body.mass[i] - a).squaredNorm();
      }
      const double expected = std::sqrt(sum / static_cast<double>(f.cols() - 2));
      EXPECT_GT(expected, 1.0) << name;
      EXPECT_NEAR(reported, expected, 1e-6 * expected) << name << rows;
    }
  }
}

TEST(DualSheet, BalancesItsHoldersWithItsMomentum) {
  // Tensions come in opposite pairs, whatever is left to do: impulse of weight, drag and holders = momentum. BDF2's
  // acceleration lags by half a step's change. Of bending, solved to a twentieth in rows, the holders feel a little
  // more or less than the sheet: some 1e-5 of the momentum.
  for (const char* name : {"line_dual", "xpbd"}) {
    Sheet sheet(true);
    System& body = *sheet.body;
    const auto integrator = make_integrator(name, sweeps(2));
    const double dt = 1e-3;
    Vec3 impulse = Vec3::Zero();
    for (int k = 1; k <= 200; ++k) {
      body.dynamics.kinematics.target.row(2).setConstant(0.02 * (1.0 - std::cos(20.0 * k * dt)));
      body.step(*integrator, dt);
      const Vec3 drag = body.state.v * body.mass;  // rate 1 / s
      impulse +=
          dt * (body.dynamics.kinematics.reaction.rowwise().sum() - drag - body.mass.sum() * Vec3(0, 0, kGravity));
    }
    const Vec3 momentum = body.state.v * body.mass;
    const double lag = std::string(name) == "line_dual" ? dt * body.mass.sum() * kGravity : 0.0;
    EXPECT_GT(momentum.norm(), 0.01);
    EXPECT_LT((impulse - momentum).norm(), 1e-5 * momentum.norm() + lag) << name;
  }
}

TEST(DualSheet, HangsStretchedByAnAmountThatShrinksWithTheStep) {
  // The false strain at rest of unconverged tensions: on the way to second order in the step (a sweep undoes the less
  // the stiffer the springs are for the step). With dampers of a time constant beyond the step: first order.
  Sheet exact(true, 5e3, 0.0);
  ASSERT_LT(relax(exact.body.get(), 0.3, 200, 1e-6), 1e-4);
  const Nodes rest = exact.body->state.x;
  std::vector<double> steps, errors;
  for (const double dt : {4e-3, 2e-3, 1e-3}) {
    Sheet sheet(true, 5e3, 0.0);
    sheet.body->state.x = rest;
    const auto integrator = make_integrator("line_dual", sweeps(1));
    for (int k = 0; k < 2.0 / dt; ++k) sheet.body->step(*integrator, dt);
    steps.push_back(dt);
    errors.push_back(std::sqrt((sheet.body->state.x - rest).squaredNorm() / 80.0));
  }
  EXPECT_GT(errors.front(), 1e-6);
  EXPECT_LT(errors.front(), 5e-3);
  EXPECT_GT(log_slope(steps, errors), 1.3);
}

TEST(DualSheet, HangsOnASoftGraspAsItsSpringsSay) {
  // k x = m g of one node on a spring to its target: attachments are solved exactly.
  for (const char* name : {"line_dual", "xpbd", "projective_dynamics"}) {
    System body(Nodes::Zero(3, 1), Eigen::VectorXd::Constant(1, 0.1));
    auto grasp = std::make_unique<TargetSprings>(std::vector<int>{0}, 50.0);
    grasp->set_targets(Vec3(0, 0, 0));
    body.add(std::move(grasp)).add_gravity();
    body.state.x(2, 0) = -0.1 * kGravity / 50.0;
    const auto integrator = make_integrator(name, sweeps(1));
    for (int k = 0; k < 50; ++k) body.step(*integrator, 0.01);
    EXPECT_NEAR(body.state.x(2, 0), -0.1 * kGravity / 50.0, 1e-14) << name;
  }
}

TEST(LineDual, FollowsAStiffPendulumOfAnyStiffness) {
  // Ten links from the horizontal for 0.3 s: the motion hardly knows the stiffness, nor does the error of one sweep.
  const auto end = [](double stiffness, const std::string& scheme, double dt) {
    std::vector<SpringLink> links;
    Nodes x = Nodes::Zero(3, 11);
    for (int i = 0; i < 10; ++i) {
      x(0, i + 1) = 0.1 * (i + 1);
      links.push_back({i, i + 1, 0.1, stiffness, 0.0});
    }
    System body(x, Eigen::VectorXd::Constant(11, 0.01));
    body.add(make_springs("chain", links, 0)).add_gravity().hold(0);
    const auto integrator = make_integrator(scheme, sweeps(1));
    for (int k = 0; k < std::lround(0.3 / dt); ++k) body.step(*integrator, dt);
    return body.state.x;
  };
  const Nodes limit = end(1e7, "rk4", 1e-5);
  for (const double stiffness : {1e7, 1e8, 1e9}) {
    const Nodes coarse = end(stiffness, "line_dual", 2e-3), fine = end(stiffness, "line_dual", 1e-3);
    EXPECT_LT((coarse - limit).norm(), 3e-4) << stiffness;
    EXPECT_LT((fine - limit).norm(), 0.3 * (coarse - limit).norm()) << stiffness;
  }
}

TEST(LineDual, InSinglePrecisionIsThatOfDouble) {
  Sheet a(true), b(true);
  const auto one = make_integrator("line_dual", sweeps(1)),
             other = make_integrator("line_dual", sweeps(1, SolverSettings::Precision::kSingle));
  for (int k = 0; k < 100; ++k) {
    a.body->step(*one, 2e-3);
    b.body->step(*other, 2e-3);
  }
  EXPECT_LT((a.body->state.x - b.body->state.x).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(DualSchemes, RefuseATermThatIsNeitherSpringNorQuadraticByName) {
  for (const char* name : {"line_dual", "xpbd", "projective_dynamics"}) {
    const TriangleMesh mesh = make_grid(0.3, 0.3, 2, 2);
    auto model = std::make_shared<Model>();
    model->mass = sheet_masses(mesh, 0.2);
    model->initial.x = mesh.rest;
    model->initial.v = Nodes::Zero(3, mesh.rest.cols());
    model->energies.push_back(make_bending(mesh, isotropic_bending(1e-4, 0.3), 0));
    const std::string term = model->energies.back()->name();
    WorldSettings settings;
    settings.integrator = name;
    try {
      World world(model, settings, {}, {});
      FAIL() << name;
    } catch (const InputError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(name), std::string::npos) << what;
      EXPECT_NE(what.find("'" + term + "'"), std::string::npos) << what;
    }
  }
}

}  // namespace
}  // namespace deformable_sim::test
