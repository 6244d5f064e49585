// Tetrahedra as a term: derivatives, conservation, damping, for every law, linear and quadratic.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/element/solid_stress.h"
#include "deformable_sim/core/error.h"
#include "support/derivative_harness.h"
#include "support/solids.h"

namespace deformable_sim::test {
namespace {

/// Two tetrahedra with a common face, of irregular shape.
TetMesh two_tets(bool quadratic) {
  TetMesh mesh;
  mesh.rest.resize(3, 5);
  mesh.rest << 0.0, 1.0, 0.2, 0.1, 0.4,  //
      0.0, 0.1, 1.1, 0.3, 0.2,           //
      0.1, 0.0, 0.1, 0.9, -0.8;
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  return quadratic ? with_mid_nodes(mesh) : mesh;
}

struct Case {
  SolidLaw law;
  bool quadratic;
};

class EverySolid : public testing::TestWithParam<Case> {
 protected:
  TetMesh mesh() const { return two_tets(GetParam().quadratic); }
  SolidMaterial material() const { return solid_material(GetParam().law, 2.6, 0.3); }
  bool can_invert() const {
    return GetParam().law != SolidLaw::kNeoHookean && GetParam().law != SolidLaw::kMooneyRivlin;
  }

  /// Homogeneous stretches at random rotations, with every node moved by up to `noise`, and random velocities.
  State state(const Vec3& s, double noise, unsigned seed) const {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(-noise, noise);
    const TetMesh m = mesh();
    State result;
    result.x = with_stretches(s, &generator) * m.rest;
    result.x = result.x.unaryExpr([&](double x) { return x + uniform(generator); }).eval();
    result.x.colwise() += Vec3(3.0, -2.0, 1.0);
    result.v = Nodes::NullaryExpr(3, m.rest.cols(), [&] { return normal(generator); });
    return result;
  }

  /// About rest, stretched, compressed, nearly flat, and (where defined) inverted.
  std::vector<State> states() const {
    std::vector<State> all;
    unsigned seed = 1;
    for (const Vec3& s : {Vec3(1, 1, 1), Vec3(1.8, 1.3, 0.9), Vec3(0.7, 0.6, 0.5), Vec3(1.2, 1.0, 0.25)}) {
      for (const double noise : {0.0, 0.03}) all.push_back(state(s, noise, seed++));
    }
    if (can_invert()) {
      all.push_back(state(Vec3(1.1, 0.9, -0.4), 0.02, seed++));
      all.push_back(state(Vec3(1.0, 0.8, 0.02), 0.0, seed++));
    }
    return all;
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const SolidLaw law : kSolidLaws) {
    cases.push_back({law, false});
    cases.push_back({law, true});
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Laws, EverySolid, testing::ValuesIn(all_cases()), [](const auto& info) {
  return name_of(info.param.law) + (info.param.quadratic ? "_quadratic" : "_linear");
});

TEST_P(EverySolid, HasTheDerivativesItDelivers) {
  // f = -dE/dx and A = -(dx df/dx + dv df/dv) against central differences, damped and undamped.
  for (const double damping : {0.0, 0.4}) {
    const auto term = make_solid(mesh(), material(), damping, 0);
    int k = 0;
    for (const State& s : states()) {
      SCOPED_TRACE("state " + std::to_string(k++) + ", damping " + std::to_string(damping));
      check_derivatives(term.get(), s, true);
    }
  }
}

TEST_P(EverySolid, LeavesMomentumAlone) {
  // sum f = 0; sum x x f = 0 but for Hooke's linear law, which is not invariant under rotation.
  const auto term = make_solid(mesh(), material(), 0.4, 0);
  for (const State& s : states()) {
    const Nodes f = force_of(*term, s);
    const Vec3 center = s.x.rowwise().mean();
    Vec3 torque = Vec3::Zero();
    for (Eigen::Index i = 0; i < f.cols(); ++i) torque += (s.x.col(i) - center).cross(f.col(i));
    EXPECT_LT(f.rowwise().sum().norm(), 1e-12 * (1.0 + f.norm()));
    if (GetParam().law != SolidLaw::kHooke) EXPECT_LT(torque.norm(), 1e-12 * (1.0 + f.norm()));
  }
}

TEST_P(EverySolid, TurnsWithTheBody) {
  // E(Rx + t) = E(x), f(Rx + t, Rv) = R f(x, v) for all laws but Hooke's linear one, which must show that it is not.
  const auto term = make_solid(mesh(), material(), 0.4, 0);
  std::mt19937 generator(5);
  for (const State& s : states()) {
    const Mat3 r = random_rotation(&generator);
    State turned = s;
    turned.x = (r * s.x).colwise() + Vec3(0.3, 0.2, -0.5);
    turned.v = r * s.v;
    const Nodes f = force_of(*term, s);
    const double energy = std::abs(term->value(turned) - term->value(s)) / (1.0 + term->value(s));
    const double force = (force_of(*term, turned) - r * f).norm() / (1.0 + f.norm());
    EXPECT_EQ(energy < 1e-12, GetParam().law != SolidLaw::kHooke) << energy;
    EXPECT_EQ(force < 1e-12, GetParam().law != SolidLaw::kHooke) << force;
  }
}

TEST_P(EverySolid, DampsNoRigidMotionInAnyDeformation) {
  // v = omega x x + t: F^T Fdot is antisymmetric, the rate of Green-Lagrange strain zero, and so is the viscous force.
  const auto damped = make_solid(mesh(), material(), 1.0, 0), free = make_solid(mesh(), material(), 0.0, 0);
  for (State s : states()) {
    const Vec3 omega(0.3, -0.5, 0.7), center = s.x.rowwise().mean();
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) s.v.col(i) = omega.cross(s.x.col(i) - center) + Vec3(0.1, 0.2, -0.1);
    const Nodes viscous = force_of(*damped, s) - force_of(*free, s);
    EXPECT_LT(viscous.cwiseAbs().maxCoeff(), 1e-14 * (1.0 + force_of(*free, s).norm()));
  }
}

TEST_P(EverySolid, DissipatesOtherwise) {
  // f_v . v = -sum w S_v : Edot < 0.
  const auto damped = make_solid(mesh(), material(), 1.0, 0), free = make_solid(mesh(), material(), 0.0, 0);
  for (const State& s : states()) {
    EXPECT_LT((force_of(*damped, s) - force_of(*free, s)).cwiseProduct(s.v).sum(), -1e-3);
  }
}

TEST_P(EverySolid, IsDampedInProportionToItsStiffnessAtRest) {
  // df/dv = tau df/dx at rest: a mode of frequency omega has the damping ratio tau omega / 2.
  const double tau = 0.4;
  const auto term = make_solid(mesh(), material(), tau, 0);
  State s;
  s.x = mesh().rest;
  s.v = Nodes::Zero(3, s.x.cols());
  std::vector<std::array<int, 2>> pairs;
  term->add_pattern(&pairs);
  BlockMatrix matrix(static_cast<int>(s.x.cols()), pairs);
  term->bind(matrix);
  const Eigen::MatrixXd stiffness = delivered_jacobian(*term, s, 1.0, 0.0, Jacobian::kExact, &matrix);
  const Eigen::MatrixXd damping = delivered_jacobian(*term, s, 0.0, 1.0, Jacobian::kExact, &matrix);
  EXPECT_LT((damping - tau * stiffness).norm(), 1e-13 * stiffness.norm());
}

TEST_P(EverySolid, CarriesNoStressWhenTurned) {
  // max |P| / mu < 1e-14 under any rotation, all laws but Hooke's linear one.
  std::mt19937 generator(6);
  const TetMesh m = mesh();
  for (int k = 0; k < 50; ++k) {
    const Nodes x = random_rotation(&generator) * m.rest;
    for (const Mat3& f : deformation_gradients(m, x)) {
      const double stress = first_piola(material(), f).cwiseAbs().maxCoeff() / material().mu;
      EXPECT_EQ(stress < 1e-14, GetParam().law != SolidLaw::kHooke) << stress;
    }
  }
}

TEST(Solids, RefuseWhatIsNoMaterial) {
  const TetMesh mesh = two_tets(false);
  const SolidMaterial good = solid_material(SolidLaw::kStableNeoHookean, 1.0, 0.3);
  SolidMaterial bad = good;
  bad.mu = 0.0;
  EXPECT_THROW(make_solid(mesh, bad, 0.0, 0), InputError);
  bad = good;
  bad.lambda = -bad.mu;
  EXPECT_THROW(make_solid(mesh, bad, 0.0, 0), InputError);
  bad = good;
  bad.share = 1.5;
  EXPECT_THROW(make_solid(mesh, bad, 0.0, 0), InputError);
  EXPECT_THROW(make_solid(mesh, good, -1.0, 0), InputError);
  EXPECT_THROW(solid_masses(mesh, 0.0), InputError);
  EXPECT_THROW(solid_mass_matrix(mesh, -1.0), InputError);
}

TEST(Solids, AreNamedByElementAndLaw) {
  const SolidMaterial material = solid_material(SolidLaw::kStableNeoHookean, 1.0, 0.3);
  const auto linear = make_solid(two_tets(false), material, 0.0, 0);
  EXPECT_EQ(linear->name(), "tetrahedra: stable_neo_hookean");
  EXPECT_EQ(linear->element_count(), 2);
  EXPECT_EQ(make_solid(two_tets(true), material, 0.0, 0)->name(), "quadratic tetrahedra: stable_neo_hookean");
}

TEST(Solids, ActOnTheNodesTheyAreShiftedTo) {
  // The same forces `first_node` columns further on.
  const TetMesh mesh = two_tets(true);
  const SolidMaterial material = solid_material(SolidLaw::kCorotational, 1.0, 0.3);
  State own, shifted;
  own.x = 1.1 * mesh.rest;
  own.v = Nodes::Zero(3, own.x.cols());
  shifted.x = Nodes::Zero(3, own.x.cols() + 7);
  shifted.x.rightCols(own.x.cols()) = own.x;
  shifted.v = Nodes::Zero(3, shifted.x.cols());
  const Nodes f = force_of(*make_solid(mesh, material, 0.0, 7), shifted);
  EXPECT_EQ(f.leftCols(7).norm(), 0.0);
  EXPECT_EQ(f.rightCols(own.x.cols()), force_of(*make_solid(mesh, material, 0.0, 0), own));
}

}  // namespace
}  // namespace deformable_sim::test
