// Bicubic upsampling of grids: through the nodes, smooth, exact where it says so.
#include <gtest/gtest.h>

#include <cmath>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/topology/skin.h"
#include "deformable_sim/core/topology/upsampling.h"

namespace deformable_sim {
namespace {

/// The grid's nodes moved to f(column, row).
template <class Function>
Nodes shaped(int rows, int cols, Function f) {
  Nodes x(3, rows * cols);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < cols; ++c) x.col(r * cols + c) = f(static_cast<double>(c), static_cast<double>(r));
  return x;
}

/// Largest distance of the upsampled points from the function that the nodes were taken from.
template <class Function>
double furthest_from(Function f, int rows, int cols, int factor, int margin) {
  const TriangleMesh grid = make_grid(1, 1, cols - 1, rows - 1);
  const Nodes fine = shaped(rows, cols, f) * upsample(grid, factor).weights;
  const int fine_cols = (cols - 1) * factor + 1, fine_rows = (rows - 1) * factor + 1;
  double furthest = 0.0;
  for (int r = margin * factor; r < fine_rows - margin * factor; ++r) {
    for (int c = margin * factor; c < fine_cols - margin * factor; ++c) {
      const Vec3 expected = f(static_cast<double>(c) / factor, static_cast<double>(r) / factor);
      furthest = std::max(furthest, (fine.col(r * fine_cols + c) - expected).norm());
    }
  }
  return furthest;
}

TEST(Upsampling, InterpolatesTheNodes) {
  // y(node) = x_node: the spline's weights at t = 0 are 0 1 0 0.
  const TriangleMesh grid = make_grid(0.6, 0.4, 5, 4);
  const Nodes x = Nodes::Random(3, grid.rest.cols());
  for (const int factor : {1, 2, 5}) {
    const Nodes fine = x * upsample(grid, factor).weights;
    const int fine_cols = 5 * factor + 1;
    for (int r = 0; r <= 4; ++r)
      for (int c = 0; c <= 5; ++c)
        EXPECT_EQ((fine.col(r * factor * fine_cols + c * factor) - x.col(r * 6 + c)).norm(), 0.0) << r << " " << c;
  }
}

TEST(Upsampling, IsExactForAffineMotions) {
  // y(A x + b) = A y(x) + b, for the weights of each point add up to one; at the smallest grids too.
  const Mat3 a = Mat3::Random();
  const Vec3 b = Vec3::Random();
  for (const auto& [cells_x, cells_y] : {std::pair(1, 1), std::pair(1, 3), std::pair(2, 2), std::pair(7, 5)}) {
    const TriangleMesh grid = make_grid(0.7, 0.5, cells_x, cells_y),
                       same = make_grid(0.7, 0.5, 3 * cells_x, 3 * cells_y);
    const Nodes rest = grid.rest * upsample(grid, 3).weights;
    EXPECT_LT((rest - same.rest).cwiseAbs().maxCoeff(), 1e-15);
    const Nodes moved = ((a * grid.rest).colwise() + b) * upsample(grid, 3).weights;
    EXPECT_LT((moved - ((a * rest).colwise() + b)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Upsampling, ReproducesQuadraticsUpToTheRim) {
  // Central differences, and the parabola through the last three nodes at the rim, give the slopes of quadratics
  // exactly.
  const auto quadratic = [](double c, double r) {
    return Vec3(c + 0.3 * r * r, r - 0.2 * c * c + 0.1 * c * r,
                0.5 * c * c * r * r - 0.7 * c * r * r + c * c - r + 2.0);
  };
  EXPECT_LT(furthest_from(quadratic, 5, 6, 4, 0), 1e-12);
  EXPECT_LT(furthest_from(quadratic, 3, 3, 4, 0), 1e-13);
  // Cubics are beyond it: their slope is missed by h^2 f''' / 6 = 1, which shows between the nodes:
  // (t - 3 t^2 + 2 t^3) at its largest, sqrt(3) / 18.
  const auto cubic = [](double c, double) { return Vec3(0, 0, c * c * c); };
  EXPECT_NEAR(furthest_from(cubic, 3, 6, 32, 1), std::sqrt(3.0) / 18.0, 2e-4);
}

TEST(Upsampling, IsOfThirdOrder) {
  // A cylinder of radius 1: the error of a Catmull-Rom curve through its nodes falls with the third power of their
  // spacing at least (fourth inside, third in the parabola at the rim).
  double before = 0.0;
  for (const int cells : {8, 16, 32}) {
    const double h = 2.0 / cells;
    const auto bent = [&](double c, double r) { return Vec3(std::sin(h * c), h * r, 1.0 - std::cos(h * c)); };
    const double error = furthest_from(bent, 3, cells + 1, 8, 0);
    if (before > 0.0) {
      EXPECT_GT(std::log2(before / error), 2.8);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-4);
}

TEST(Upsampling, HasContinuousTangentsAcrossCells) {
  // C1: one-sided difference quotients on both sides of every node line of a random surface agree as the samples close
  // up; of a kinked surface they would stay apart by the kink, of order 1.
  const TriangleMesh grid = make_grid(1, 1, 5, 5);
  const Nodes x = Nodes::Random(3, 36);
  double gap[2];
  const int factors[2] = {16, 32};
  for (int k = 0; k < 2; ++k) {
    const int factor = factors[k], cols = 5 * factor + 1;
    const Nodes fine = x * upsample(grid, factor).weights;
    gap[k] = 0.0;
    for (int r = 0; r < cols; ++r) {
      for (int c = factor; c < cols - 1; c += factor) {
        const auto at = [&](int row, int col) -> Vec3 { return fine.col(row * cols + col); };
        gap[k] = std::max(gap[k], factor * (at(r, c + 1) - 2.0 * at(r, c) + at(r, c - 1)).norm());
        gap[k] = std::max(gap[k], factor * (at(c + 1, r) - 2.0 * at(c, r) + at(c - 1, r)).norm());
      }
    }
  }
  EXPECT_NEAR(gap[0] / gap[1], 2.0, 0.2);
}

TEST(Upsampling, OvershootsNoMoreThanAnEighthOfTheRange) {
  // 0 1 1 0 along a line: 1 + t / 2 - t^2 / 2, at most 9/8.
  const TriangleMesh grid = make_grid(1, 1, 3, 1);
  Nodes x = Nodes::Zero(3, 8);
  for (const int node : {1, 2, 5, 6}) x(2, node) = 1.0;
  const Nodes fine = x * upsample(grid, 8).weights;
  EXPECT_NEAR(fine.row(2).maxCoeff(), 1.125, 1e-12);
}

TEST(Upsampling, RefusesWhatItCannotRefine) {
  TriangleMesh mesh = make_grid(1, 1, 2, 2);
  EXPECT_THROW(upsample(mesh, 0), InputError);
  EXPECT_THROW(upsample(mesh, kMaxUpsampling + 1), InputError);
  mesh.rows = mesh.cols = 0;
  EXPECT_THROW(upsample(mesh, 2), InputError);
}

TEST(UpsampledSkin, IsAGridWhoseFacesLookTheSameWay) {
  const TriangleMesh grid = make_grid(0.8, 0.3, 4, 2);
  const auto skin = make_upsampled_skin(grid, 3);
  EXPECT_EQ(skin->surface().rows, 7);
  EXPECT_EQ(skin->surface().cols, 13);
  EXPECT_EQ(skin->vertex_count(), 7 * 13);
  EXPECT_NO_THROW(check_mesh(skin->surface()));
  const Nodes normals = vertex_normals(skin->surface(), skin->positions(grid.rest));
  EXPECT_LT((normals.colwise() - Vec3::UnitZ()).norm(), 1e-12);
  // Vertex (r, c) lies nearest to node (round(r / 3), round(c / 3)).
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c < 13; ++c)
      EXPECT_EQ(skin->nearest_node()[static_cast<size_t>(r * 13 + c)], (r + 1) / 3 * 5 + (c + 1) / 3);
}

TEST(UpsampledSkin, KeepsValuesWithinThoseOfTheNodes) {
  // Weights may be negative; a strain shown must be one that is there.
  const TriangleMesh grid = make_grid(1, 1, 6, 6);
  const Eigen::VectorXf strain = Eigen::VectorXf::Random(49);
  const Eigen::VectorXf shown = make_upsampled_skin(grid, 4)->values(strain);
  EXPECT_LE(shown.maxCoeff(), strain.maxCoeff());
  EXPECT_GE(shown.minCoeff(), strain.minCoeff());
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c < 7; ++c) EXPECT_EQ(shown[4 * r * 25 + 4 * c], strain[r * 7 + c]);
}

}  // namespace
}  // namespace deformable_sim
