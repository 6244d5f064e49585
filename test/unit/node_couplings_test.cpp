// Couplings between nodes that a matrix' pattern does not join, against the dense matrix.
#include "deformable_sim/core/linear/node_couplings.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {
namespace {

constexpr int kNodes = 40;

/// A chain, (1 + 2 k) on the diagonal and -k beside it, k = 5, and couplings of four nodes anywhere, whose diagonal
/// blocks are in `chain`; all of it in `dense`.
struct System {
  System() {
    std::vector<std::array<int, 2>> pairs;
    for (int i = 1; i < kNodes; ++i) pairs.push_back({i, i - 1});
    chain = BlockMatrix(kNodes, pairs);
    dense = Eigen::MatrixXd::Zero(3 * kNodes, 3 * kNodes);
    for (int i = 0; i < kNodes; ++i) {
      add(i, i, 11.0 * Mat3::Identity());
      if (i > 0) add(i, i - 1, -5.0 * Mat3::Identity());
      if (i > 0) add(i - 1, i, -5.0 * Mat3::Identity());
    }
    std::mt19937 random(5);
    std::normal_distribution<double> some;
    std::uniform_int_distribution<int> node(0, 9);
    for (int k = 0; k < 12; ++k) {
      const Vec3 n = Vec3(some(random), some(random), some(random)).normalized();
      NodeCouplings::Coupling c{{{node(random), 10 + node(random), 20 + node(random), 30 + node(random)}},
                                {{1.0, -0.5, -0.25, -0.25}},
                                4,
                                200.0 * n * n.transpose() + 20.0 * Mat3::Identity()};
      for (size_t i = 0; i < 4; ++i) {
        chain.block(chain.diagonal_slot(c.node[i])) += c.weight[i] * c.weight[i] * c.matrix;
        for (size_t j = 0; j < 4; ++j)
          dense.block<3, 3>(3 * c.node[i], 3 * c.node[j]) += c.weight[i] * c.weight[j] * c.matrix;
      }
      couplings.add(c);
    }
    b = Nodes::NullaryExpr(3, kNodes, [&] { return some(random); });
  }
  void add(int i, int j, const Mat3& block) {
    chain.block(chain.slot(i, j)) += block;
    dense.block<3, 3>(3 * i, 3 * j) += block;
  }
  /// Relative to the exact solution.
  double error(const Nodes& x) const {
    const Eigen::VectorXd exact = dense.llt().solve(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
    return (Eigen::Map<const Eigen::VectorXd>(x.data(), x.size()) - exact).norm() / exact.norm();
  }

  BlockMatrix chain;
  Eigen::MatrixXd dense;
  NodeCouplings couplings;
  Nodes b;
};

TEST(NodeCouplings, AddWhatIsBesideTheDiagonal) {
  const System s;
  Nodes y, work;
  s.chain.multiply(s.b, &y);
  const double power = s.couplings.add_beside_diagonal([](int node) { return node; }, s.b, &y);
  const Eigen::Map<const Eigen::VectorXd> p(s.b.data(), s.b.size());
  const Eigen::VectorXd exact = s.dense * p;
  EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(y.data(), y.size()) - exact).norm(), 1e-12 * exact.norm());
  s.chain.multiply(s.b, &work);
  EXPECT_NEAR(power, p.dot(exact) - s.b.cwiseProduct(work).sum(), 1e-9 * std::abs(power));
}

TEST(NodeCouplings, AreSolvedForAroundFactors) {
  System s;
  for (const auto& make : {make_direct_solver, make_banded_solver}) {
    const std::unique_ptr<LinearSolver> solver = make();
    EXPECT_FALSE(solver->take(&s.couplings));
    solver->prepare(s.chain);
    const Eigen::VectorXd weight = Eigen::VectorXd::Ones(kNodes);
    Nodes x = Nodes::Zero(3, kNodes);
    const LinearTolerance tolerance{1e-10, 0.0, 100};
    LinearReport report = solver->solve(s.chain, s.b, weight, tolerance, &x);
    EXPECT_GT(s.error(x), 0.01);  // without what is beside the diagonal
    const auto precondition = [&](const Nodes& r, Nodes* z) {
      z->setZero(3, kNodes);
      return solver->solve(s.chain, r, weight, tolerance, z).solved;
    };
    s.couplings.solve(s.b, weight, tolerance, precondition, &x, &report);
    EXPECT_TRUE(report.solved);
    EXPECT_LT(s.error(x), 1e-8);
    EXPECT_LE(report.iterations, 4 * 12 * 3 + 1);  // of at most so many directions
  }
}

TEST(NodeCouplings, AreTakenByConjugateGradients) {
  const System s;
  const std::unique_ptr<LinearSolver> solver = make_conjugate_gradient_solver();
  ASSERT_TRUE(solver->take(&s.couplings));
  solver->prepare(s.chain);
  Nodes x = Nodes::Zero(3, kNodes);
  const LinearReport report = solver->solve(s.chain, s.b, Eigen::VectorXd::Ones(kNodes), {1e-8, 0.0, 1000}, &x);
  EXPECT_TRUE(report.solved);
  EXPECT_LT(s.error(x), 1e-6);
}

}  // namespace
}  // namespace deformable_sim
