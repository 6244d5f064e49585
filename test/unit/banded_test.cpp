// Direct solution of narrow bands: equal to a dense solution, whatever the part looks like.
#include <gtest/gtest.h>

#include <random>

#include <Eigen/Dense>

#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim::test {
namespace {

using Pairs = std::vector<std::array<int, 2>>;

/// A chain of n nodes from `first` on, coupled `reach` places far; closed: beyond its ends too.
void add_chain(int first, int n, int reach, bool closed, Pairs* pairs) {
  for (int i = 0; i < n; ++i) {
    for (int r = 1; r <= reach; ++r) {
      if (closed || i + r < n) pairs->push_back({first + i, first + (i + r) % n});
    }
  }
}

/// The same nodes, numbered at random.
void shuffle(int n, Pairs* pairs) {
  std::vector<int> number(static_cast<size_t>(n));
  for (int i = 0; i < n; ++i) number[static_cast<size_t>(i)] = i;
  std::shuffle(number.begin(), number.end(), std::mt19937(5));
  for (auto& pair : *pairs) pair = {number[static_cast<size_t>(pair[0])], number[static_cast<size_t>(pair[1])]};
}

/// Random symmetric values, each row's sum of magnitudes (times `dominance`) on its diagonal. Scalar rows keep to x.
void fill(BlockMatrix* a, double dominance) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * a->rows());
  for (int i = 0; i < a->rows(); ++i) {
    for (int k = a->row_start()[static_cast<size_t>(i)]; k < a->row_start()[static_cast<size_t>(i) + 1]; ++k) {
      const int j = a->column()[static_cast<size_t>(k)];
      if (j >= i) continue;
      Mat3 block = Mat3::NullaryExpr([&] { return uniform(generator); });
      if (i >= a->first_scalar_row()) block.bottomRows<2>().setZero();
      if (j >= a->first_scalar_row()) block.rightCols<2>().setZero();
      a->block(k) = block;
      a->block(a->slot(j, i)) = block.transpose();
      sum.segment<3>(3 * i) += block.cwiseAbs().rowwise().sum();
      sum.segment<3>(3 * j) += block.cwiseAbs().colwise().sum().transpose();
    }
  }
  for (int i = 0; i < a->rows(); ++i) {
    Mat3 block = Mat3(sum.segment<3>(3 * i).asDiagonal()) * dominance + 0.5 * Mat3::Identity();
    if (i < a->first_scalar_row()) block(0, 1) = block(1, 0) = 0.3;
    a->block(a->diagonal_slot(i)) = block;
  }
}

struct Solution {
  Nodes x;
  LinearReport report;
  double error;  // relative to the dense one
};

Solution solve(const BlockMatrix& a) {
  const auto solver = make_banded_solver();
  solver->prepare(a);
  Nodes b(3, a.rows());
  for (Eigen::Index i = 0; i < b.size(); ++i) b.data()[i] = std::sin(1.0 + 3.0 * static_cast<double>(i));
  Solution s;
  s.x = Nodes::Zero(3, a.rows());
  LinearTolerance tolerance;
  tolerance.relative = 1e-13;
  tolerance.iterations = 1000;
  s.report = solver->solve(a, b, Eigen::VectorXd::Ones(a.rows()), tolerance, &s.x);
  const Eigen::MatrixXd dense = a.to_sparse();
  const Eigen::VectorXd expected = dense.fullPivLu().solve(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
  s.error = (Eigen::Map<const Eigen::VectorXd>(s.x.data(), s.x.size()) - expected).norm() / expected.norm();
  return s;
}

void expect_dense_solution(const BlockMatrix& a, const std::string& what) {
  const Solution s = solve(a);
  EXPECT_LT(s.error, 1e-12) << what;
  EXPECT_TRUE(s.report.solved && s.report.definite) << what;
}

TEST(BandedSolver, EqualsADenseSolutionForChainsOfAnyLength) {
  // A x = b, condition number below 1e2: 1e-12 leaves rounding a factor of a hundred.
  for (int reach = 1; reach <= 8; ++reach) {
    for (int n = 1; n < 26; ++n) {
      Pairs pairs;
      add_chain(0, n, reach, false, &pairs);
      shuffle(n, &pairs);
      BlockMatrix a(n, pairs);
      fill(&a, 1.0);
      expect_dense_solution(a, std::to_string(n) + " nodes, reach " + std::to_string(reach));
      EXPECT_EQ(solve(a).report.iterations, 0);
    }
  }
}

TEST(BandedSolver, FoldsClosedLoops) {
  for (int n : {5, 6, 7, 20, 41}) {
    for (int reach : {1, 2}) {
      Pairs pairs;
      add_chain(0, n, reach, true, &pairs);
      shuffle(n, &pairs);
      BlockMatrix a(n, pairs);
      fill(&a, 1.0);
      expect_dense_solution(a, std::to_string(n) + " nodes, reach " + std::to_string(reach));
      EXPECT_EQ(solve(a).report.iterations, 0);
    }
  }
}

/// Joints of a rod of n points from `first` on: three points and two angles, coupled among each other.
void add_rod(int first, int n, int first_angle, bool closed, Pairs* pairs) {
  const int segments = closed ? n : n - 1;
  for (int k = 0; k < (closed ? n : n - 2); ++k) {
    const int nodes[5] = {first + k, first + (k + 1) % n, first + (k + 2) % n, first_angle + k,
                          first_angle + (k + 1) % segments};
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < i; ++j) pairs->push_back({nodes[i], nodes[j]});
    }
  }
  for (int k = 0; k < segments; ++k) pairs->push_back({first + k, first + (k + 1) % n});
}

TEST(BandedSolver, TakesTheAnglesOfRodsForRowsOfOneUnknown) {
  for (bool closed : {false, true}) {
    for (int n : {2, 3, 4, 5, 6, 7, 12, 31}) {
      if (closed && n < 4) continue;
      Pairs pairs;
      add_rod(0, n, n, closed, &pairs);
      BlockMatrix a(closed ? 2 * n : 2 * n - 1, pairs, n);
      fill(&a, 1.0);
      expect_dense_solution(a, std::to_string(n) + (closed ? " points, closed" : " points"));
      EXPECT_EQ(solve(a).report.iterations, 0);
    }
  }
}

TEST(BandedSolver, SolvesEachBodyOfAScene) {
  // Two ropes and a rod directly, a sheet of 12 x 12 nodes by conjugate gradients.
  Pairs pairs;
  add_chain(0, 9, 2, false, &pairs);
  add_chain(9, 12, 1, true, &pairs);
  const auto sheet = [](int i, int j) { return 21 + 12 * i + j; };
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      if (i < 11) pairs.push_back({sheet(i, j), sheet(i + 1, j)});
      if (j < 11) pairs.push_back({sheet(i, j), sheet(i, j + 1)});
    }
  }
  add_rod(165, 8, 173, false, &pairs);
  BlockMatrix a(180, pairs, 173);
  fill(&a, 1.5);
  expect_dense_solution(a, "ropes and a sheet");
  EXPECT_GT(solve(a).report.iterations, 0);
}

TEST(BandedSolver, LeavesHeldNodesWhereTheyAre) {
  // Rows and columns of held nodes are identity: x_i = b_i there.
  Pairs pairs;
  add_chain(0, 30, 2, false, &pairs);
  BlockMatrix a(30, pairs);
  fill(&a, 1.0);
  for (int node : {0, 1, 14, 29}) {
    for (int j = 0; j < 30; ++j) {
      if (a.slot(node, j) < 0) continue;
      a.block(a.slot(node, j)).setZero();
      a.block(a.slot(j, node)).setZero();
    }
    a.block(a.diagonal_slot(node)).setIdentity();
  }
  expect_dense_solution(a, "held nodes");
  EXPECT_EQ(solve(a).x(1, 14), std::sin(1.0 + 3.0 * 43.0));
}

TEST(BandedSolver, SaysSoWhenTheMatrixIsNotDefinite) {
  // Half the diagonal sums: eigenvalues of both signs; the solution is still that of A x = b.
  for (int negative : {2, 10, 17}) {  // in one lane, in the middle, in the other
    Pairs pairs;
    add_chain(0, 20, 2, false, &pairs);
    BlockMatrix a(20, pairs);
    fill(&a, 1.0);
    a.block(a.diagonal_slot(negative)) *= -1.0;
    const Solution s = solve(a);
    EXPECT_FALSE(s.report.definite);
    EXPECT_TRUE(s.report.solved);
    EXPECT_LT(s.error, 1e-10);
  }
}

TEST(BandedSolver, DoesNotMoveWhereTheMatrixIsSingular) {
  for (int empty : {0, 9, 19}) {
    Pairs pairs;
    add_chain(0, 20, 2, false, &pairs);
    BlockMatrix a(20, pairs);
    for (int i = 0; i < 20; ++i) a.block(a.diagonal_slot(i)).setIdentity();
    a.block(a.diagonal_slot(empty)).setZero();
    const Solution s = solve(a);
    EXPECT_FALSE(s.report.solved);
    EXPECT_FALSE(s.report.definite);
    EXPECT_TRUE(s.x.isZero(0.0));
  }
}

TEST(BandedSolver, IsExactForRopesABillionTimesStifferAlong) {
  // k n n^T along each segment beside a mass of 1: |A x - b| / (|A| |x|) is rounding though the condition is 1e9.
  const int n = 400;
  Pairs pairs;
  add_chain(0, n, 1, false, &pairs);
  BlockMatrix a(n, pairs);
  for (int i = 0; i < n; ++i) a.block(a.diagonal_slot(i)).setIdentity();
  for (int i = 0; i + 1 < n; ++i) {
    const Vec3 along(std::cos(0.1 * i), std::sin(0.1 * i), 0.3);
    const Mat3 k = 1e9 * along * along.transpose();
    a.block(a.diagonal_slot(i)) += k;
    a.block(a.diagonal_slot(i + 1)) += k;
    a.block(a.slot(i, i + 1)) -= k;
    a.block(a.slot(i + 1, i)) -= k;
  }
  const auto solver = make_banded_solver();
  solver->prepare(a);
  const Nodes b = Nodes::Ones(3, n);
  Nodes x = Nodes::Zero(3, n), product;
  EXPECT_TRUE(solver->solve(a, b, Eigen::VectorXd::Ones(n), {}, &x).definite);
  a.multiply(x, &product);
  EXPECT_LT((product - b).norm() / (4e9 * x.norm()), 1e-14);
}

}  // namespace
}  // namespace deformable_sim::test
