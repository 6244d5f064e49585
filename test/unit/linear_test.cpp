// The block matrix and the two ways to solve with it.
#include <gtest/gtest.h>

#include <random>

#include "deformable_sim/core/linear/linear_solver.h"
#include "support/system.h"

namespace deformable_sim::test {
namespace {

/// Matrix of an implicit step of a sheet: M / dt^2 + K, projected, at a crumpled state.
struct StepMatrix {
  explicit StepMatrix(int cells, double dt) : body(mesh_of(cells).rest, sheet_masses(mesh_of(cells), 0.15)) {
    SheetStiffness stiffness;
    stiffness.membrane = 300.0;
    body.add_springs(sheet_network(mesh_of(cells), stiffness));
    body.build_pattern();
    std::mt19937 generator(3);
    std::normal_distribution<double> normal(0.0, 0.1 / cells);
    body.state.x += Nodes::NullaryExpr(3, body.state.x.cols(), [&] { return normal(generator); });
    matrix = body.pattern;
    for (const Energy* energy : body.dynamics.energies) {
      energy->add_jacobian(body.state, 1.0, 0.0, Jacobian::kProjected, &matrix);
    }
    for (int i = 0; i < matrix.rows(); ++i) {
      matrix.block(matrix.diagonal_slot(i)).diagonal().array() += body.mass[i] / (dt * dt);
    }
    right_side = Nodes::NullaryExpr(3, matrix.rows(), [&] { return normal(generator); });
    weight = body.mass.cwiseInverse();
  }
  static TriangleMesh mesh_of(int cells) { return make_grid(1, 1, cells, cells); }
  double relative_residual(const Nodes& x) const {
    Nodes product;
    matrix.multiply(x, &product);
    return (product - right_side).norm() / right_side.norm();
  }

  System body;
  BlockMatrix matrix;
  Nodes right_side;
  Eigen::VectorXd weight;
};

TEST(BlockMatrix, HasTheDiagonalAndBothOrientations) {
  const BlockMatrix matrix(4, {{2, 0}, {0, 2}, {1, 3}});
  EXPECT_EQ(matrix.rows(), 4);
  EXPECT_EQ(matrix.block_count(), 8);
  EXPECT_GE(matrix.slot(0, 2), 0);
  EXPECT_GE(matrix.slot(2, 0), 0);
  EXPECT_EQ(matrix.slot(0, 1), -1);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(matrix.slot(i, i), matrix.diagonal_slot(i));
}

TEST(BlockMatrix, MultipliesLikeItsScalarCopy) {
  BlockMatrix matrix(3, {{0, 1}, {1, 2}});
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < matrix.block_count(); ++k) {
    matrix.block(k) = Mat3::NullaryExpr([&] { return normal(generator); });
  }
  const Nodes x = Nodes::NullaryExpr(3, 3, [&] { return normal(generator); });
  Nodes y;
  matrix.multiply(x, &y);
  const Eigen::VectorXd expected = matrix.to_sparse() * Eigen::Map<const Eigen::VectorXd>(x.data(), 9);
  EXPECT_LT((Eigen::Map<const Eigen::VectorXd>(y.data(), 9) - expected).norm(), 1e-14);
}

TEST(DirectSolver, SolvesToRounding) {
  const StepMatrix step(8, 0.01);
  const auto solver = make_direct_solver();
  solver->prepare(step.matrix);
  Nodes x = Nodes::Zero(3, step.matrix.rows());
  EXPECT_TRUE(solver->solve(step.matrix, step.right_side, step.weight, {}, &x).solved);
  EXPECT_LT(step.relative_residual(x), 1e-12);
}

TEST(ConjugateGradients, ReachTheToleranceAskedForThoughTheyRunInSinglePrecision) {
  const StepMatrix step(8, 0.01);
  const auto solver = make_conjugate_gradient_solver();
  solver->prepare(step.matrix);
  for (const double tolerance : {1e-2, 1e-5, 1e-11}) {
    LinearTolerance asked;
    asked.relative = tolerance;
    Nodes x = Nodes::Zero(3, step.matrix.rows());
    const LinearReport report = solver->solve(step.matrix, step.right_side, step.weight, asked, &x);
    EXPECT_TRUE(report.solved);
    EXPECT_LT(step.relative_residual(x), 3.0 * tolerance);  // masses weigh the tolerance, up to 4 : 1
  }
}

TEST(ConjugateGradients, NeedFewIterationsWhateverTheMesh) {
  // The scalar solve carries the smooth part: iterations must not grow with the number of cells as block-Jacobi's do.
  for (const int cells : {8, 16, 32}) {
    const StepMatrix step(cells, 0.01);
    const auto solver = make_conjugate_gradient_solver();
    solver->prepare(step.matrix);
    Nodes x = Nodes::Zero(3, step.matrix.rows());
    EXPECT_LE(solver->solve(step.matrix, step.right_side, step.weight, {}, &x).iterations, 10) << cells;
  }
}

TEST(ConjugateGradients, StayDefiniteBesideStiffContacts) {
  StepMatrix step(12, 0.01);
  const auto solver = make_conjugate_gradient_solver();
  solver->prepare(step.matrix);
  for (int i = 0; i < step.matrix.rows(); i += 2) {
    step.matrix.block(step.matrix.diagonal_slot(i))(2, 2) += 1e3 * step.body.mass[i] / 1e-4;
  }
  Nodes x = Nodes::Zero(3, step.matrix.rows());
  LinearTolerance asked;
  asked.relative = 1e-6;
  const LinearReport report = solver->solve(step.matrix, step.right_side, step.weight, asked, &x);
  EXPECT_TRUE(report.solved);
  EXPECT_LT(report.iterations, 100);
}

}  // namespace
}  // namespace deformable_sim::test
