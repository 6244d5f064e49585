// Multigrid on aggregates: groups, the coarse correction, and what conjugate gradients need with it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/linear/aggregation_multigrid.h"
#include "deformable_sim/core/linear/constant_links.h"
#include "deformable_sim/core/linear/multigrid_solver.h"
#include "support/crooked_system.h"

namespace deformable_sim::test {
namespace {

PaddedNodes padded_noise(int n, unsigned seed) {
  PaddedNodes x = PaddedNodes::Zero(4, n);
  x.topRows<3>() = noise(n, 1.0, seed).cast<float>();
  return x;
}

GraphMatrix laplacian_of(const TriangleMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [a, b] : edges_of(mesh)) {
    for (const auto& [i, j] : {std::array<int, 2>{a, b}, std::array<int, 2>{b, a}}) {
      entries.emplace_back(i, j, -100.0);
      entries.emplace_back(i, i, 100.0);
    }
  }
  GraphMatrix laplacian(mesh.rest.cols(), mesh.rest.cols());
  laplacian.setFromTriplets(entries.begin(), entries.end());
  return laplacian;
}

/// 5 to 15 N/m, other values on each axis.
AxisValues sums(int n) {
  AxisValues sum = AxisValues::Zero(4, n);
  sum.topRows<3>() = noise(n, 1.0, 5).cast<float>().cwiseMin(2.0f).cwiseMax(-2.0f) * 2.5f;
  sum.topRows<3>().array() += 10.0f;
  return sum;
}

TEST(Aggregates, PartTheNodesIntoGroupsOfNeighbours) {
  // A group is a node with all its neighbours, or has more that are linked to one of those; a lone node is in none.
  const TriangleMesh mesh = crooked_sheet(12);
  const GraphMatrix laplacian = laplacian_of(mesh);
  GraphMatrix links(145, 145);  // one node more, alone
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < 144; ++i) {
    for (GraphMatrix::InnerIterator it(laplacian, i); it; ++it) {
      if (it.col() != i) entries.emplace_back(i, static_cast<int>(it.col()), -it.value());
    }
  }
  links.setFromTriplets(entries.begin(), entries.end());
  int count = 0, again = 0;
  const std::vector<int> group = aggregates(links, &count);
  EXPECT_EQ(group, aggregates(links, &again));
  EXPECT_EQ(group[144], -1);
  EXPECT_LT(count, 144 / 4);
  EXPECT_GT(count, 144 / 16);
  std::vector<int> size(static_cast<size_t>(count), 0);
  for (int i = 0; i < 144; ++i) {
    ASSERT_GE(group[static_cast<size_t>(i)], 0);
    ++size[static_cast<size_t>(group[static_cast<size_t>(i)])];
    int friends = 0;
    for (GraphMatrix::InnerIterator it(links, i); it; ++it) {
      friends += group[static_cast<size_t>(it.col())] == group[static_cast<size_t>(i)] ? 1 : 0;
    }
    EXPECT_GT(friends, 0);
  }
  EXPECT_GT(*std::min_element(size.begin(), size.end()), 2);
}

TEST(AggregationMultigrid, IsSymmetricAndPositive) {
  // <C r, s> = <r, C s> and <r, C r> > 0 for smooth r; single precision.
  const TriangleMesh mesh = crooked_sheet(40);
  const int n = static_cast<int>(mesh.rest.cols());
  for (const SimdLevel level : {SimdLevel::kSse2, simd_level()}) {
    AggregationMultigrid coarse(block_kernels(level));
    coarse.prepare(laplacian_of(mesh));
    ASSERT_GE(coarse.sizes().size(), 2U);
    ASSERT_TRUE(coarse.refresh(sums(n)));
    PaddedNodes cr(4, n), cs(4, n);
    for (unsigned seed = 1; seed < 5; ++seed) {
      const PaddedNodes r = padded_noise(n, seed), s = padded_noise(n, seed + 50);
      coarse.correct(r, &cr);
      coarse.correct(s, &cs);
      const double size = std::sqrt(dot(cr, r) * dot(cs, s));
      EXPECT_NEAR(dot(cr, s), dot(r, cs), 1e-5 * size);
      EXPECT_GT(dot(cr, r), 0.0);
      EXPECT_EQ(cr.row(3).cwiseAbs().maxCoeff(), 0.0f);
    }
  }
}

TEST(AggregationMultigrid, SolvesExactlyForATranslationWithOneCoarseLevel) {
  // (L + S) 1 = S 1, and coarse diagonals are P^T S 1 with P 1 = 1: the correction of it is 1.
  const TriangleMesh mesh = crooked_sheet(12);
  const int n = static_cast<int>(mesh.rest.cols());
  AggregationMultigrid coarse(block_kernels(simd_level()));
  coarse.prepare(laplacian_of(mesh));
  ASSERT_EQ(coarse.sizes().size(), 1U);
  const AxisValues sum = sums(n);
  ASSERT_TRUE(coarse.refresh(sum));
  PaddedNodes found(4, n);
  coarse.correct(sum, &found);
  EXPECT_LT((found.topRows<3>().array() - 1.0f).abs().maxCoeff(), 1e-5f);
}

TEST(AggregationMultigrid, GivesUpWhereALevelIsNotDefinite) {
  const TriangleMesh mesh = crooked_sheet(12);
  const int n = static_cast<int>(mesh.rest.cols());
  AggregationMultigrid coarse(block_kernels(simd_level()));
  coarse.prepare(laplacian_of(mesh));
  EXPECT_FALSE(coarse.refresh(-sums(n)));
  PaddedNodes found = padded_noise(n, 1);
  coarse.correct(padded_noise(n, 2), &found);
  EXPECT_EQ(found.cwiseAbs().maxCoeff(), 0.0f);
}

Nodes exact(const BlockMatrix& a, const Sheet& sheet) {
  Nodes x = Nodes::Zero(3, a.rows());
  const auto direct = make_direct_solver();
  direct->prepare(a);
  direct->solve(a, sheet.right_side, sheet.weight, {}, &x);
  return x;
}

TEST(MultigridSolver, SolvesWhatTheSparseFactorisationSolves) {
  // A x = b to four digits of the residual, the most that single precision gives.
  Sheet sheet(14);
  sheet.links.clear();
  Nodes found;
  EXPECT_TRUE(sheet.solve(1e-9, &found).solved);
  const Nodes expected = exact(sheet.blocks, sheet);
  EXPECT_LT((found - expected).norm(), 1e-3 * expected.norm());
}

TEST(MultigridSolver, SeesLinksApartAsIfTheyWereInTheMatrix) {
  // Left out are links of less than a hundredth of the rows' sums: of what the links change, less than a tenth is
  // wrong.
  const Sheet sheet(14);
  Nodes found;
  EXPECT_TRUE(sheet.solve(1e-4, &found).solved);
  const Nodes expected = exact(sheet.whole, sheet), without = exact(sheet.blocks, sheet);
  EXPECT_LT((found - expected).norm(), 0.1 * (without - expected).norm());
}

TEST(MultigridSolver, NeedsFewMoreIterationsOnLargerMeshes) {
  // Of a sheet whose stiffness spreads far in a step; at most a half more for four times the nodes, and twice for
  // sixteen times. With block Jacobi alone the number doubles with each, from 40 on.
  std::vector<int> iterations;
  for (const int side : {16, 32, 64}) {
    Nodes x;
    const LinearReport report = Sheet(side, Sheet::Shape::kStretched).solve(1e-3, &x);
    EXPECT_TRUE(report.solved);
    iterations.push_back(report.iterations);
  }
  EXPECT_LE(iterations[1], 1.5 * iterations[0]);
  EXPECT_LE(iterations[2], 2.0 * iterations[0]);
  EXPECT_LE(iterations[2], 20);
}

TEST(ConstantLinks, OfHingesAreTheJacobianAcrossAFlatSheet) {
  // -df_z/dz - (1 / tau) df_z/dv_z at rest is what quadratic bending has along all axes; by hinges it is 0 in the
  // plane.
  const TriangleMesh mesh = crooked_sheet(7);
  BendingMaterial material = isotropic_bending(1e-3, 0.3);
  material.damping = 0.02;
  const double tau = 0.01;
  System body(mesh.rest, sheet_masses(mesh, 0.2));
  body.add(make_bending(mesh, material, 0)).build_pattern();
  const Energy* term = body.dynamics.energies[0];
  BlockMatrix a = body.pattern;
  term->add_jacobian(body.state, 1.0, 1.0 / tau, Jacobian::kProjected, &a);
  const ConstantLinks* links = term->constant_links();
  ASSERT_NE(links, nullptr);
  const double scale = 1.0 + links->damping / tau, largest = scale * links->sum[24];
  for (size_t row = 0; row < links->sum.size(); ++row) {
    const int i = links->node[row];
    EXPECT_NEAR(a.block(a.diagonal_slot(i))(2, 2), scale * links->sum[row], 1e-6 * largest);
    for (int k = links->row_start[row]; k < links->row_start[row + 1]; ++k) {
      const auto at = static_cast<size_t>(k);
      if (links->stiffness[at] == 0.0) continue;
      const int slot = a.slot(i, static_cast<int>(links->place[at] / 4));
      ASSERT_GE(slot, 0);
      EXPECT_NEAR(a.block(slot)(2, 2), -scale * links->stiffness[at], 1e-6 * largest);
    }
  }
}

TEST(MultigridSolver, SeesSpringsApartAsIfTheyWereInTheMatrix) {
  // The same matrix to single precision, node 0 held: the same solution to what the tolerance leaves.
  Sheet sheet(14);
  std::vector<const Energy*> terms = sheet.body.dynamics.energies;
  std::vector<SpringElement> springs;
  for (const KnownSpring& s : take_springs(&terms).springs) {
    springs.push_back({s.a, s.b, s.length, s.stiffness, s.damping});
  }
  ASSERT_FALSE(springs.empty());
  Nodes whole, apart = Nodes::Zero(3, sheet.blocks.rows());
  const LinearReport expected = sheet.solve(1e-4, &whole);
  BlockMatrix rest(sheet.blocks.rows(), {});
  for (int i = 1; i < rest.rows(); ++i) {
    rest.block(rest.diagonal_slot(i)).diagonal().setConstant(sheet.body.mass[i] / (Sheet::kTau * Sheet::kTau));
  }
  rest.block(rest.diagonal_slot(0)).setIdentity();
  const auto solver = make_multigrid_solver();
  solver->set_links(sheet.links, Sheet::kTau, {0});
  solver->set_springs(springs);
  solver->place_springs(sheet.body.state.x, 1.0, 1.0 / Sheet::kTau, MultigridSolver::Transverse::kProjected);
  solver->prepare(rest);
  LinearTolerance asked;
  asked.relative = 1e-4;
  const LinearReport report = solver->solve(rest, sheet.right_side, sheet.weight, asked, &apart);
  EXPECT_TRUE(report.solved);
  EXPECT_NEAR(report.iterations, expected.iterations, 2);
  EXPECT_LT((apart - whole).norm(), 2e-3 * whole.norm());
  EXPECT_EQ(apart.col(0), Vec3::Zero());
}

}  // namespace
}  // namespace deformable_sim::test
