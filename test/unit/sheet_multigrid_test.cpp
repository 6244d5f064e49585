// The coarser grids of a sheet against dense matrices.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "deformable_sim/core/grid/sheet_multigrid.h"
#include "deformable_sim/core/grid/sheet_system.h"
#include "support/grid_terms.h"

namespace deformable_sim::test {
namespace {

constexpr double kMass = 2e-3;   // kg
constexpr double kRate = 3e4;    // 1/s^2, inertia over mass
constexpr double kSweep = 0.65;  // weight of block-Jacobi sweeps
using Matrix = Eigen::MatrixXd;

/// Springs with made up directions and tensions in the layout of SheetMatrix, and their dense matrix, three numbers a
/// node. Nothing is held.
class Springs {
 public:
  explicit Springs(const GridSheet& sheet) : rows_(sheet), width_(stage_kernels(simd_level()).width), sheet_(sheet) {
    const std::ptrdiff_t stride = rows_.shape().stride;
    springs_ = RowArray<float>(sheet.rows, SheetMatrix::kNumbers * SheetMatrix::kSprings * stride);
    matrix_.springs = springs_.data();
    dense = Matrix::Zero(3 * sheet.node_count(), 3 * sheet.node_count());
    std::mt19937 random(5);
    std::normal_distribution<float> some;
    for (int node = 0; node < sheet.node_count(); ++node) {
      const int row = node / sheet.cols, col = node % sheet.cols;
      constexpr int kTo[4][2] = {{0, 1}, {1, 0}, {1, 1}, {1, -1}};
      for (int k = 0; k < 4; ++k) {
        const int other_row = row + kTo[k][0], other_col = col + kTo[k][1];
        if (other_row >= sheet.rows || other_col < 0 || other_col >= sheet.cols) continue;
        const float q[3] = {20.0f * some(random), 20.0f * some(random), 20.0f * some(random)};
        const float t = 50.0f * std::abs(some(random));
        put(node, k, q, t);
        const Vec3 direction(q[0], q[1], q[2]);
        add(node, other_row * sheet.cols + other_col,
            direction * direction.transpose() + static_cast<double>(t) * Mat3::Identity());
      }
    }
  }
  /// All stiffnesses, but for the dense matrix.
  void scale(double factor) {
    const std::ptrdiff_t stride = rows_.shape().stride;
    for (std::ptrdiff_t at = 0; at < sheet_.rows * stride * SheetMatrix::kNumbers * SheetMatrix::kSprings; ++at) {
      const bool tension = at / width_ % SheetMatrix::kNumbers == 3;
      springs_.data()[at] *= static_cast<float>(tension ? factor : std::sqrt(factor));
    }
  }
  const SheetMatrix& matrix() const { return matrix_; }
  const SheetShape<float>& shape() const { return rows_.shape(); }
  std::ptrdiff_t place(int node) const { return rows_.place(node); }
  XyzArray<float> make() const { return rows_.make_xyz(); }

  Matrix dense;

 private:
  void put(int node, int k, const float* q, float t) {
    const int col = node % sheet_.cols, lane = col % width_;
    float* p =
        matrix_.springs + SheetMatrix::kNumbers * (SheetMatrix::kSprings * (place(node) - lane) + k * width_) + lane;
    for (int d = 0; d < 3; ++d) p[d * width_] = q[d];
    p[3 * width_] = t;
  }
  void add(int a, int b, const Mat3& k) {
    dense.block<3, 3>(3 * a, 3 * a) += k;
    dense.block<3, 3>(3 * b, 3 * b) += k;
    dense.block<3, 3>(3 * a, 3 * b) -= k;
    dense.block<3, 3>(3 * b, 3 * a) -= k;
  }

  SheetRows<float> rows_;
  int width_;
  const GridSheet& sheet_;
  RowArray<float> springs_;
  SheetMatrix matrix_{};
};

/// Interpolation along a line: every other node is a coarse one.
Matrix halving(int count) {
  if (count <= 3) return Matrix::Identity(count, count);
  Matrix p = Matrix::Zero(count, count / 2 + 1);
  for (int k = 0; k < count; ++k) {
    if (k % 2 == 0) {
      p(k, k / 2) = 1.0;
    } else {
      p(k, k / 2) = p(k, k / 2 + 1) = 0.5;
    }
  }
  return p;
}
Matrix kron(const Matrix& a, const Matrix& b) {
  Matrix whole(a.rows() * b.rows(), a.cols() * b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j)
      whole.block(i * b.rows(), j * b.cols(), b.rows(), b.cols()) = a(i, j) * b;
  return whole;
}

/// The cycle by its definition: B of z = B r, for the matrix `a` of rows x cols nodes.
Matrix cycle(const Matrix& a, int rows, int cols) {
  const Eigen::Index n = a.rows();
  if (rows <= 3 && cols <= 3) return a.llt().solve(Matrix::Identity(n, n));
  Matrix jacobi = Matrix::Zero(n, n);
  for (Eigen::Index k = 0; k < n; k += 3) jacobi.block<3, 3>(k, k) = kSweep * a.block<3, 3>(k, k).inverse();
  const Matrix p_rows = halving(rows), p_cols = halving(cols), p = kron(kron(p_rows, p_cols), Mat3::Identity());
  const Matrix below = cycle(p.transpose() * a * p, static_cast<int>(p_rows.cols()), static_cast<int>(p_cols.cols()));
  const Matrix one = Matrix::Identity(n, n);
  // 1 - B A is the product of what the three corrections leave.
  const Matrix left = (one - jacobi * a) * (one - p * below * p.transpose() * a) * (one - jacobi * a);
  return (one - left) * a.llt().solve(one);
}

/// The correction by the grids below the finest, as a dense matrix.
Matrix correction(const Springs& springs, SheetMultigrid* grids, int nodes) {
  Matrix b(3 * nodes, 3 * nodes);
  for (int j = 0; j < 3 * nodes; ++j) {
    auto r = springs.make(), z = springs.make();
    float* const from[3] = {r.data().x, r.data().y, r.data().z};
    from[j % 3][springs.place(j / 3)] = 1.0f;
    grids->correct(r.data(), z.data());
    const float* const to[3] = {z.data().x, z.data().y, z.data().z};
    for (int i = 0; i < 3 * nodes; ++i) b(i, j) = static_cast<double>(to[i % 3][springs.place(i / 3)]);
  }
  return b;
}

GridSheet plain_sheet(int rows, int cols) {
  GridSheet sheet;
  sheet.rows = rows;
  sheet.cols = cols;
  return sheet;
}

TEST(SheetMultigrid, IsTheVCycleOfGalerkinOperators) {
  // z = P V(P^T A P) P^T r, V by its definition: with even and odd numbers of nodes, strips, one grid and several.
  for (const auto& [rows, cols] :
       {std::pair(2, 2), {5, 5}, {4, 6}, {3, 9}, {9, 2}, {8, 7}, {9, 9}, {12, 11}, {6, 37}}) {
    for (SimdLevel level : levels()) {
      setenv("DEFORMABLE_SIM_SIMD", name_of(level), 1);
      const GridSheet sheet = plain_sheet(rows, cols);
      const int nodes = rows * cols;
      const Springs springs(sheet);
      SheetMultigrid grids(sheet, std::vector<double>(static_cast<size_t>(nodes), kMass),
                           std::vector<char>(static_cast<size_t>(nodes), 1));
      grids.tune(kRate, 0.0);
      grids.refresh(springs.shape(), springs.matrix(), {});
      const Matrix a = springs.dense + kMass * kRate * Matrix::Identity(3 * nodes, 3 * nodes);
      const Matrix p_rows = halving(rows), p_cols = halving(cols), p = kron(kron(p_rows, p_cols), Mat3::Identity());
      const Matrix below =
          cycle(p.transpose() * a * p, static_cast<int>(p_rows.cols()), static_cast<int>(p_cols.cols()));
      const Matrix expected = p * below * p.transpose();
      const Matrix found = correction(springs, &grids, nodes);
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 2e-5 * expected.cwiseAbs().maxCoeff())
          << rows << " x " << cols << " " << name_of(level);
      unsetenv("DEFORMABLE_SIM_SIMD");
    }
  }
}

TEST(SheetMultigrid, KnowsWhatTiesNodesToTheGround) {
  // With a block X at a node of the coarse grid P^T (A + X) P is P^T A P + X there: no lumping.
  const GridSheet sheet = plain_sheet(5, 5);
  const Springs springs(sheet);
  SheetMultigrid grids(sheet, std::vector<double>(25, kMass), std::vector<char>(25, 1));
  grids.tune(kRate, 0.0);
  grids.refresh(springs.shape(), springs.matrix(), {{12, {9e3f, 1e3f, -2e3f, 7e3f, 5e2f, 8e3f}}});
  Mat3 x;
  x << 9e3, 1e3, -2e3, 1e3, 7e3, 5e2, -2e3, 5e2, 8e3;
  Matrix a = springs.dense + kMass * kRate * Matrix::Identity(75, 75);
  a.block<3, 3>(36, 36) += x;
  const Matrix p = kron(kron(halving(5), halving(5)), Mat3::Identity());
  const Matrix expected = p * cycle(p.transpose() * a * p, 3, 3) * p.transpose();
  EXPECT_LT((correction(springs, &grids, 25) - expected).cwiseAbs().maxCoeff(), 2e-5 * expected.cwiseAbs().maxCoeff());
  // ... and it is forgotten with the next matrix.
  grids.refresh(springs.shape(), springs.matrix(), {});
  a.block<3, 3>(36, 36) -= x;
  const Matrix without = p * cycle(p.transpose() * a * p, 3, 3) * p.transpose();
  EXPECT_LT((correction(springs, &grids, 25) - without).cwiseAbs().maxCoeff(), 2e-5 * without.cwiseAbs().maxCoeff());
}

/// Bending of a sheet as a dense matrix, and its P^T K P with what reaches over two coarse nodes on the diagonal.
Matrix bending_of(const GridSheet& sheet) {
  Matrix k = Matrix::Zero(sheet.node_count(), sheet.node_count());
  for (int node = 0; node < sheet.node_count(); ++node) {
    const int row = node / sheet.cols, col = node % sheet.cols;
    const auto& kind = sheet.bending.kind[static_cast<size_t>(sheet.bending.kind_of_row[static_cast<size_t>(row)])];
    for (size_t e = 0; e < kStencil.size(); ++e) {
      const int r = row + kStencil[e][0], c = col + kStencil[e][1];
      if (r < 0 || r >= sheet.rows || c < 0 || c >= sheet.cols) continue;
      k(node, r * sheet.cols + c) = kind[e][static_cast<size_t>(col)];
    }
  }
  return k;
}
Matrix lumped(Matrix k, int cols) {
  for (int i = 0; i < k.rows(); ++i) {
    for (int j = 0; j < k.cols(); ++j) {
      if (std::abs(i / cols - j / cols) <= 1 && std::abs(i % cols - j % cols) <= 1) continue;
      k(i, i) += k(i, j);
      k(i, j) = 0.0;
    }
  }
  return k;
}

TEST(SheetMultigrid, KnowsBendingAndHeldNodes) {
  // P^T S P + P^T X P + inertia P^T M P + factor P^T K P over the free nodes but for S, the springs of all, and X, the
  // springs of held ones as ground beneath them; with X and what K does over two coarse nodes on the diagonal.
  constexpr double kFactor = 1.7;
  const GridTerms terms({4, 4, true, false, false, true});
  const GridSheet& sheet = *terms.grid;
  const int n = sheet.node_count();
  for (const std::vector<int>& held : {std::vector<int>{}, {0}, {7, 12, 24}}) {
    std::vector<char> free(static_cast<size_t>(n), 1);
    for (int node : held) free[static_cast<size_t>(node)] = 0;
    const Springs springs(sheet);
    SheetMultigrid grids(sheet, std::vector<double>(free.size(), kMass), free);
    grids.tune(kRate, kFactor);
    grids.refresh(springs.shape(), springs.matrix(), {});
    const Matrix line = kron(halving(5), halving(5));
    Matrix kept = Matrix::Identity(n, n), ground = Matrix::Zero(27, 27);
    for (int node : held) {
      kept(node, node) = 0.0;
      for (int c = 0; c < 9; ++c) {
        ground.block<3, 3>(3 * c, 3 * c) += line(node, c) * springs.dense.block<3, 3>(3 * node, 3 * node);
      }
    }
    const Matrix of_free = kept * line, p = kron(line, Mat3::Identity()), mine = kron(of_free, Mat3::Identity());
    const Matrix scalar = kMass * kRate * of_free.transpose() * of_free +
                          kFactor * lumped(of_free.transpose() * bending_of(sheet) * of_free, 3);
    const Matrix coarse = p.transpose() * springs.dense * p + ground + kron(scalar, Mat3::Identity());
    const Matrix expected = mine * coarse.llt().solve(Matrix::Identity(27, 27)) * mine.transpose();
    const Matrix found = correction(springs, &grids, n);
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 2e-5 * expected.cwiseAbs().maxCoeff()) << held.size();
  }
}

TEST(SheetMultigrid, StaysDefiniteWhateverTheSpringsAre) {
  // r . B r >= 0, > 0 for what the coarse grid can see; with held nodes, bending, and springs up to 1e9 N/m.
  for (double stiffness : {1e-3, 1.0, 1e3, 1e9}) {
    GridTerms terms({8, 6, true, true, false, true});
    const int nodes = terms.grid->node_count();
    std::vector<char> free(static_cast<size_t>(nodes), 1);
    free[0] = free[3] = free[20] = 0;
    Springs springs(*terms.grid);
    springs.scale(stiffness);
    SheetMultigrid grids(*terms.grid, std::vector<double>(free.size(), kMass), free);
    grids.tune(kRate, 2.0);
    grids.refresh(springs.shape(), springs.matrix(), {});
    const Matrix b = correction(springs, &grids, nodes);
    EXPECT_LT((b - b.transpose()).cwiseAbs().maxCoeff(), 1e-4 * b.cwiseAbs().maxCoeff()) << stiffness;
    const Matrix symmetric = 0.5 * (b + b.transpose());
    const Eigen::VectorXd lambda = Eigen::SelfAdjointEigenSolver<Matrix>(symmetric).eigenvalues();
    EXPECT_GT(lambda[0], -1e-5 * lambda[lambda.size() - 1]) << stiffness;
    for (int node : {0, 3, 20}) EXPECT_EQ(b.middleRows(3 * node, 3).cwiseAbs().maxCoeff(), 0.0);
  }
}

}  // namespace
}  // namespace deformable_sim::test
