// Explicit steps in parts: the same motion as velocity Verlet makes, with and without rows of a grid.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/error.h"
#include "support/solids.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

/// A term of which nothing is known but its force: no kernel takes its place.
class Unknown : public Energy {
 public:
  explicit Unknown(const Energy* term) : term_(term) {}
  std::string name() const override { return term_->name(); }
  int element_count() const override { return term_->element_count(); }
  double value(const State& s) const override { return term_->value(s); }
  void add_force(const State& s, Nodes* f) const override { term_->add_force(s, f); }
  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override { term_->add_pattern(pairs); }
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const State&, double, double, Jacobian, BlockMatrix*) const override {}

 private:
  const Energy* term_;
};

/// A sheet hung from a corner, beside two nodes on a spring that belong to no sheet.
struct Scene {
  explicit Scene(bool in_rows, double damping = 0.0, bool hold = true) {
    const TriangleMesh mesh = make_grid(0.4, 0.3, 12, 9);
    const auto n = mesh.rest.cols();
    Nodes x(3, n + 2);
    x.leftCols(n) = mesh.rest;
    x.col(n) = Vec3(2, 0, 0);
    x.col(n + 1) = Vec3(2.15, 0, 0);
    Eigen::VectorXd mass = Eigen::VectorXd::Constant(n + 2, 0.01);
    mass.head(n) = sheet_masses(mesh, 0.2);
    body = std::make_unique<System>(x, mass);
    SheetStiffness stiffness;
    stiffness.membrane = 200.0;
    stiffness.bend = 2.0;
    stiffness.damping_time = damping;
    const SpringNetwork network = sheet_network(mesh, stiffness);
    const auto weights = grid_bending_weights(mesh, isotropic_bending(1e-4, 0.2));
    body->add_springs(network).add(make_quadratic_links("bending", weights, damping, 0));
    const std::vector<const Energy*> terms = body->dynamics.energies;
    body->add(make_springs("springs", {{static_cast<int>(n), static_cast<int>(n) + 1, 0.1, 50.0, 0.0}}, 0));
    body->add_gravity();
    if (damping > 0.0) body->add(make_mass_damping(mass, 2.0));
    if (hold) body->hold(0);
    if (!in_rows) return;
    grids.push_back(*make_grid_sheet(mesh, network, weights, damping, 0));
    grids[0].replaces = terms;
    body->dynamics.grids = &grids;
  }

  /// All terms but gravity and drag per mass as forces alone.
  void forget_kinds() {
    for (const Energy*& term : body->dynamics.energies) {
      if (term->mass_force() != nullptr) continue;
      unknown.push_back(std::make_unique<Unknown>(term));
      term = unknown.back().get();
    }
  }

  std::unique_ptr<System> body;
  std::vector<GridSheet> grids;
  std::vector<std::unique_ptr<Unknown>> unknown;
};

/// 0.2 s of one motion: by kernels, by terms of which nothing is known, and by kernels in single precision.
void move(Scene* kernels, Scene* terms, Scene* single) {
  terms->forget_kinds();
  SolverSettings half;
  half.precision = SolverSettings::Precision::kSingle;
  const auto a = make_integrator("substepped_verlet", {}), b = make_integrator("substepped_verlet", {});
  const auto c = make_integrator("substepped_verlet", half);
  for (int k = 0; k < 20; ++k) {
    kernels->body->step(*a, 0.01);
    terms->body->step(*b, 0.01);
    single->body->step(*c, 0.01);
  }
}

TEST(SubsteppedVerlet, IsVelocityVerletInPartsOfTheStep) {
  // Without forces of velocity the merged kicks are those of velocity Verlet with the parts as steps: equal to
  // rounding, and so is the mean force at the held node.
  for (const bool in_rows : {false, true}) {
    Scene parts(in_rows), whole(false);
    const auto cutting = make_integrator("substepped_verlet", {}), plain = make_integrator("velocity_verlet", {});
    for (int k = 0; k < 10; ++k) {
      Vec3 reaction = Vec3::Zero();
      const Vec3 target = parts.body->state.x.col(0) + Vec3(0.001, 0, 0.002);
      parts.body->dynamics.kinematics.target.col(0) = target;
      const int count = parts.body->step(*cutting, 0.01).force_evaluations - 1;
      ASSERT_GT(count, 5);
      const Vec3 start = whole.body->state.x.col(0);
      for (int i = 1; i <= count; ++i) {
        whole.body->dynamics.kinematics.target.col(0) = start + i * (target - start) / count;
        whole.body->step(*plain, 0.01 / count);
        reaction += whole.body->dynamics.kinematics.reaction.col(0) / count;
      }
      EXPECT_LT((parts.body->state.x - whole.body->state.x).cwiseAbs().maxCoeff(), 1e-12) << in_rows << k;
      EXPECT_LT((parts.body->state.v - whole.body->state.v).cwiseAbs().maxCoeff(), 1e-10);
      EXPECT_LT((parts.body->dynamics.kinematics.reaction.col(0) - reaction).norm(), 1e-9);
    }
  }
}

TEST(SubsteppedVerlet, MovesASheetInRowsAsItMovesItsTerms) {
  // With damping of springs, of bending and of mass: terms and rows are the same forces.
  Scene rows(true, 0.003), terms(false, 0.003), single(true, 0.003);
  move(&rows, &terms, &single);
  EXPECT_GT((rows.body->state.x - Scene(true).body->state.x).cwiseAbs().maxCoeff(), 0.05);
  // The drag per mass is semi-implicit in both; the order of additions differs.
  EXPECT_LT((rows.body->state.x - terms.body->state.x).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((rows.body->state.x - single.body->state.x).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_GT((rows.body->state.x - single.body->state.x).cwiseAbs().maxCoeff(), 0.0);
}

TEST(SubsteppedVerlet, MovesAMeshInPacketsAsItMovesItsTerms) {
  // Packets know nothing of the grid. Without damping of bending its links act in every part: the same forces, equal to
  // rounding; with it they act in every few, each of which turns the fastest motion by 0.15 at most, an error of
  // 0.15^2 / 24 of bending's share.
  for (const double damping : {0.0, 0.003}) {
    Scene packets(false, damping), terms(false, damping), single(false, damping);
    move(&packets, &terms, &single);
    const Nodes& x = packets.body->state.x;
    EXPECT_LT((x - terms.body->state.x).cwiseAbs().maxCoeff(), damping > 0.0 ? 1e-5 : 1e-11);
    EXPECT_LT((x - single.body->state.x).cwiseAbs().maxCoeff(), 1e-4);
    EXPECT_GT((x - single.body->state.x).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_LT((packets.body->dynamics.kinematics.reaction - terms.body->dynamics.kinematics.reaction).norm(),
              damping > 0.0 ? 1e-3 : 1e-9);
  }
}

TEST(SubsteppedVerlet, CutsTheStepFinerWhenAsked) {
  // A quarter of the limit: four times the parts; refused beyond the limit and at nothing.
  SolverSettings fine;
  fine.fraction_of_limit = 0.95 / 4.0;
  Scene a(true), b(true);
  const int whole = a.body->step(*make_integrator("substepped_verlet", {}), 0.1).force_evaluations - 1;
  const int parts = b.body->step(*make_integrator("substepped_verlet", fine), 0.1).force_evaluations - 1;
  EXPECT_GT(parts, 4 * (whole - 1));
  EXPECT_LE(parts, 4 * whole);
  for (const double bad : {0.0, -1.0, 1.0, std::nan("")}) {
    fine.fraction_of_limit = bad;
    EXPECT_THROW(make_integrator("substepped_verlet", fine), InputError) << bad;
  }
}

TEST(SubsteppedVerlet, BeginsAgainAsANewOneDoes) {
  // After reset() nothing is left of what was measured before: the same bits as a scheme that was never used.
  Scene used(true), fresh(true);
  const auto old = make_integrator("substepped_verlet", {}), young = make_integrator("substepped_verlet", {});
  const State start = used.body->state;
  for (Eigen::Index i = 1; i < used.body->state.x.cols(); ++i) used.body->state.x(0, i) *= 1.5;
  used.body->step(*old, 0.01);  // measures at a stretched state
  used.body->state = start;
  old->reset();
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(used.body->step(*old, 0.1).force_evaluations, fresh.body->step(*young, 0.1).force_evaluations);
  }
  EXPECT_EQ(used.body->state.x, fresh.body->state.x);
  EXPECT_EQ(used.body->state.v, fresh.body->state.v);
}

TEST(SubsteppedVerlet, KeepsTheMomentumOfAFreeSheet) {
  // Internal forces are opposite pairs: p = p0 + m g t.
  Scene scene(true, 0.0, false);
  for (Eigen::Index i = 0; i < scene.body->state.x.cols(); ++i) scene.body->state.v(2, i) = 0.3 * std::sin(7.0 * i);
  const Vec3 before = scene.body->state.v * scene.body->mass;
  const auto integrator = make_integrator("substepped_verlet", {});
  for (int k = 0; k < 20; ++k) scene.body->step(*integrator, 0.01);
  const Vec3 expected = before + 0.2 * scene.body->mass.sum() * Vec3(0, 0, -kGravity);
  EXPECT_LT((scene.body->state.v * scene.body->mass - expected).norm(), 1e-13);
}

TEST(SubsteppedVerlet, LaysASheetOnAFloorWithItsWeight) {
  // At rest the floor carries m g; every node stays on its side.
  Scene scene(true, 0.003, false);
  const auto n = scene.body->state.x.cols();
  const auto integrator = make_integrator("substepped_verlet", {});
  double mean = 0.0;
  for (int k = 0; k < 100; ++k) {
    scene.body->dynamics.contacts.assign(static_cast<size_t>(n), {});
    for (int i = 0; i < n; ++i) {
      ContactConstraint& c = scene.body->dynamics.contacts[static_cast<size_t>(i)];
      c.node[0] = i;
      c.offset = -0.05;
      c.friction = 0.5;
    }
    scene.body->step(*integrator, 0.01);
    EXPECT_GT(scene.body->state.x.row(2).minCoeff(), -0.05 - 1e-12);
    if (k < 80) continue;
    for (const ContactConstraint& c : scene.body->dynamics.contacts) mean += c.force.z() / 20.0;
  }
  // It still settles: 1e-3 m/s in 0.2 s are 0.02 % of g.
  EXPECT_NEAR(mean / (scene.body->mass.sum() * kGravity), 1.0, 1e-3);
  EXPECT_LT(scene.body->state.v.cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SubsteppedVerlet, ShortensItsPartsWhereABodyIsSqueezed) {
  // A cantilever of solid elements droops until it hangs. What is squeezed grows stiffer than it was at rest: parts of
  // the length measured there feed its fastest motion. Nothing is damped: the energy stays what it was, to the h^2 of
  // the method and far below the weight times the length.
  const TetMesh mesh = make_box(Vec3(0.4, 0.1, 0.1), {4, 1, 1});
  System body(mesh.rest, solid_masses(mesh, 1000.0));
  body.add(make_solid(mesh, solid_material(SolidLaw::kStableNeoHookean, 1e4, 0.3), 0.0, 0)).add_gravity();
  for (int i = 0; i < static_cast<int>(mesh.rest.cols()); ++i) {
    if (mesh.rest(0, i) < -0.199) body.hold(i);
  }
  const double weight = kGravity * body.mass.sum() * 0.4, start = body.potential_energy();
  const auto integrator = make_integrator("substepped_verlet", {});
  double furthest = 0.0;
  for (int k = 0; k < 120; ++k) {
    body.step(*integrator, 1.0 / 60.0);
    furthest = std::max(furthest, std::abs(body.kinetic_energy() + body.potential_energy() - start));
    ASSERT_LT(furthest, 0.05 * weight) << "step " << k;
  }
}

}  // namespace
}  // namespace deformable_sim::test
