// Explicit steps of springs on any mesh in packets: the same sums as the terms', and when links may wait.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/integrator/mesh_motion.h"
#include "support/crooked_sheet.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

/// A crooked sheet of damped springs and quadratic bending in motion, one node held, between nodes without springs.
struct Sheet {
  Sheet() : mesh(crooked_sheet(9)) {
    const auto n = mesh.rest.cols();
    Nodes x = Nodes::Zero(3, n + 2);
    Eigen::VectorXd mass = Eigen::VectorXd::Constant(n + 2, 0.01);
    x.middleCols(1, n) = mesh.rest;
    mass.segment(1, n) = sheet_masses(mesh, 0.2);
    body = std::make_unique<System>(x, mass);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      body->state.x.data()[i] += 0.01 * std::sin(5.0 * i);
      body->state.v.data()[i] = 0.3 * std::cos(3.0 * i);
    }
    SheetStiffness stiffness;
    stiffness.membrane = 300.0;
    stiffness.damping_time = 0.002;
    body->add(make_springs("springs", sheet_network(mesh, stiffness).stretch, 1));
    const auto weights = quadratic_bending_weights(mesh, isotropic_bending(1e-4, 0.3));
    body->add(make_quadratic_links("bending", weights, 0.01, 1)).hold(4);
    std::vector<const Energy*> others = body->dynamics.energies;
    terms = take_springs(&others);
    EXPECT_TRUE(others.empty());
    links = terms.links;
  }
  Nodes force(size_t term, const State& s) const {
    Nodes f = Nodes::Zero(3, s.x.cols());
    body->dynamics.energies[term]->add_force(s, &f);
    return f;
  }

  TriangleMesh mesh;
  std::unique_ptr<System> body;
  SpringTerms terms;
  std::vector<const ConstantLinks*> links;
};

/// Leaps, links that may wait in the second, against sums over the terms:
///   v += kick / (1 + r) (f / m + g) - 2 r / (1 + r) v,  r = rate kick / 2,   x += drift v,
/// f of links that wait that of v + slow / 2 times what they gave before. In single precision the links' force on what
/// the start is bent acts in every leap.
template <class Real>
void compare(const Sheet& sheet, SimdLevel level, const LinkSplit& split, int leaps, double tolerance) {
  const System& body = *sheet.body;
  MeshMotion<Real> motion(sheet.terms, body.mass, body.dynamics.kinematics.node, split, level);
  EXPECT_TRUE(motion.contains(1) && motion.contains(81));
  EXPECT_FALSE(motion.contains(0) || motion.contains(82));
  const MassForce everywhere{Vec3(0.1, -0.2, -9.8), 3.0};
  Nodes more = 1e-3 * body.state.x, impulses = Nodes::Zero(3, 1), expected_impulses = impulses;
  const double kick = 2e-4, drift = 3e-4, slow = split.together > 1 ? 4.0 * kick : kick, half = 0.5 * 3.0 * kick;

  State plain = body.state;
  State now = plain;
  motion.load(now, 1e-2);
  State still = plain;
  still.v.setZero();
  Nodes bent = sheet.force(1, still);
  if (std::is_same<Real, double>::value) bent.setZero();
  Nodes gave = Nodes::Zero(3, plain.x.cols());
  for (int k = 0; k < leaps; ++k) {
    const bool bends = split.together == 1 || k != 1;
    motion.leap(kick, bends ? slow : 0.0, drift, everywhere, &more, &impulses);
    Nodes impulse = kick * (sheet.force(0, plain) + more + bent);
    State ahead = plain;
    if (split.together > 1) ahead.v += 0.5 * slow * gave;
    const Nodes bending = sheet.force(1, ahead) - bent;
    if (bends) {
      impulse += slow * bending;
      gave = bending * body.mass.cwiseInverse().asDiagonal();
      gave.col(4).setZero();
    }
    expected_impulses += impulse.col(4);
    for (int i = 1; i < 82; ++i) {
      if (i != 4) {
        plain.v.col(i) += (impulse.col(i) / body.mass[i] + kick * everywhere.acceleration) / (1.0 + half) -
                          2.0 * half / (1.0 + half) * plain.v.col(i);
      }
      plain.x.col(i) += drift * plain.v.col(i);
    }
  }
  motion.store(&now.x, &now.v);
  EXPECT_LT((now.v - plain.v).cwiseAbs().maxCoeff(), 1e3 * tolerance) << name_of(level);
  EXPECT_LT((now.x - plain.x).cwiseAbs().maxCoeff(), tolerance) << name_of(level);
  EXPECT_LT((impulses - expected_impulses).norm(), tolerance) << name_of(level);
  Vec3 x, v;
  motion.set(7, Vec3(0.1, 0.2, -0.3), Vec3(4, 5, -6));
  motion.get(7, &x, &v);
  EXPECT_LT((x - Vec3(0.1, 0.2, -0.3)).norm() + (v - Vec3(4, 5, -6)).norm(), 10.0 * tolerance);
}

TEST(MeshMotion, IsTheSumOverItsTermsAtEveryLevel) {
  // Equal to rounding; in single precision positions are counted in 1e-9 m, and what roots and sums of velocities of
  // 1 m/s lose is 1e-6 of them.
  const Sheet sheet;
  LinkSplit every, all_slow;
  all_slow.fastest = 1e12;
  all_slow.together = 4;
  for (const SimdLevel level : {SimdLevel::kSse2, SimdLevel::kAvx2, SimdLevel::kAvx512}) {
    if (level > simd_level()) continue;
    for (const LinkSplit& split : {every, all_slow}) {
      compare<double>(sheet, level, split, 3, 1e-14);
      compare<float>(sheet, level, split, 3, 1e-8);
    }
  }
}

TEST(MeshMotion, SplitsLinksWithoutLosingAny) {
  // Fast and slow links together are all links, whatever is called fast: with equal impulses nothing depends on it.
  const Sheet sheet;
  for (const double fastest : {10.0, 300.0, 3000.0}) {
    LinkSplit split;
    split.fastest = fastest;
    compare<double>(sheet, simd_level(), split, 1, 1e-14);
  }
}

TEST(LinkSplit, LeavesSlowLinksSlow) {
  // What waits has no eigenvalue above what the shares allow: t lambda^(1/2) <= 0.15, t c lambda <= 0.25.
  const Sheet sheet;
  const double part = 1e-4;
  const LinkSplit split = split_links(sheet.links, sheet.body->mass, part);
  ASSERT_GT(split.together, 1);
  EXPECT_GE(split.longest, split.together * part);
  EXPECT_LE(split.longest, 0.01);
  const ConstantLinks& links = *sheet.links.front();
  Eigen::MatrixXd slow = Eigen::MatrixXd::Zero(81, 81);
  int fast = 0;
  for (size_t row = 0; row < links.sum.size(); ++row) {
    const int i = links.node[row];
    for (int k = links.row_start[row]; k < links.row_start[row + 1]; ++k) {
      const int j = static_cast<int>(links.place[static_cast<size_t>(k)] / 4);
      const double m = sheet.body->mass[1 + i], other = sheet.body->mass[1 + j];
      const double value = links.stiffness[static_cast<size_t>(k)];
      if (std::abs(value) > split.fastest * std::sqrt(m * other)) {
        ++fast;
        continue;
      }
      slow(i, j) -= value / std::sqrt(m * other);
      slow(i, i) += value / m;
    }
  }
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(slow).eigenvalues().cwiseAbs().maxCoeff();
  EXPECT_LE(split.longest * std::sqrt(largest), 0.15);
  EXPECT_LE(split.longest * 0.01 * largest, 0.25);
  EXPECT_LT(fast, links.row_start.back() / 2);
}

TEST(LinkSplit, LetsNothingWaitWithoutDamping) {
  // Nothing would take what impulses feed to springs that swing with them.
  const Sheet sheet;
  ConstantLinks undamped = *sheet.links.front();
  undamped.damping = 0.0;
  EXPECT_EQ(split_links({&undamped}, sheet.body->mass, 1e-5).together, 1);
  EXPECT_EQ(split_links({}, sheet.body->mass, 1e-5).together, 1);
}

}  // namespace
}  // namespace deformable_sim::test
