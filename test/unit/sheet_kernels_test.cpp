// Sheets on grids: the kernels against the terms they stand for, and what is no grid.
#include <gtest/gtest.h>

#include "support/grid_terms.h"

namespace deformable_sim::test {
namespace {

TEST(SheetKernels, HaveTheForcesOfTheTermsTheyStandFor) {
  // Equal to rounding of each precision, which in single is that of k L, some hundred times the smallest of the largest
  // forces; with every feature, at every width, and at sizes below, at and above a register.
  for (const auto& [cells_x, cells_y] : {std::pair(1, 1), {2, 3}, {7, 4}, {15, 9}, {16, 2}, {33, 17}}) {
    for (int bits = 0; bits < 16; ++bits) {
      const GridTerms sheet({cells_x, cells_y, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0});
      ASSERT_TRUE(sheet.grid) << bits;
      const Nodes expected = sheet.force_of_terms();
      const double size = expected.cwiseAbs().maxCoeff();
      for (SimdLevel level : levels()) {
        const auto error = [&](const Nodes& force) { return (force - expected).cwiseAbs().maxCoeff() / size; };
        EXPECT_LT(error(sheet.force_of_kernels(level)), 1e-13)
            << cells_x << " x " << cells_y << ", " << bits << ", " << name_of(level);
        EXPECT_LT(error(sheet.force_of_motion<double>(level)), 1e-13)
            << cells_x << " x " << cells_y << ", " << bits << ", " << name_of(level);
        EXPECT_LT(error(sheet.force_of_motion<float>(level)), 2e-5)
            << cells_x << " x " << cells_y << ", " << bits << ", " << name_of(level);
      }
    }
  }
}

TEST(SheetKernels, HaveNoForceBetweenNodesAtOnePlace) {
  // d = 0: no direction; nothing that is not a number.
  GridTerms sheet({4, 4, true, true, true, true});
  sheet.state.x.setZero();
  sheet.state.v.setZero();
  for (SimdLevel level : levels()) {
    EXPECT_EQ(sheet.force_of_kernels(level).cwiseAbs().maxCoeff(), 0.0);
    EXPECT_EQ(sheet.force_of_motion<float>(level).cwiseAbs().maxCoeff(), 0.0);
  }
}

TEST(SheetMotion, LeapsAsItsFormulaSays) {
  // v1 = ((1 - r k / 2) v + k (f / m + g)) / (1 + r k / 2), x1 = x + d v1; again from there, with the forces of the
  // terms at x1: what lies beside rows has moved along. Held nodes keep v. Single precision: to 1e-6 of what moves.
  for (const auto& [cells_x, cells_y] : {std::pair(2, 3), {7, 4}, {16, 2}, {33, 5}}) {
    GridTerms sheet({cells_x, cells_y, true, true, true, true});
    const Eigen::Index n = sheet.state.x.cols();
    const Eigen::VectorXd mass = Eigen::VectorXd::LinSpaced(n, 0.02, 0.03);
    const int held = GridTerms::kFirst + cells_x;
    MassForce everywhere;
    everywhere.acceleration = Vec3(0.3, 0.2, -9.81);
    everywhere.rate = 3.0;
    const double kick = 2e-3, drift = 1e-3, half = 0.5 * everywhere.rate * kick;
    State state = sheet.state;
    for (int part = 0; part < 2; ++part) {
      const Nodes f = sheet.force_of_terms();
      State& s = sheet.state;
      for (int i = GridTerms::kFirst; i < GridTerms::kFirst + sheet.grid->node_count(); ++i) {
        if (i != held) {
          s.v.col(i) =
              ((1.0 - half) * s.v.col(i) + kick * (f.col(i) / mass[i] + everywhere.acceleration)) / (1.0 + half);
        }
        s.x.col(i) += drift * s.v.col(i);
      }
    }
    const auto check = [&](auto motion, double tolerance, SimdLevel level) {
      Nodes x = state.x, v = state.v;
      motion.load(state.x, state.v, 0.01);
      motion.leap(kick, drift, everywhere, nullptr);
      motion.leap(kick, drift, everywhere, nullptr);
      motion.store(&x, &v);
      EXPECT_LT((x - sheet.state.x).cwiseAbs().maxCoeff(), tolerance) << cells_x << ", " << name_of(level);
      EXPECT_LT((v - sheet.state.v).cwiseAbs().maxCoeff() * drift, tolerance) << cells_x << ", " << name_of(level);
    };
    for (SimdLevel level : levels()) {
      check(SheetMotion<double>(*sheet.grid, mass, {held}, level), 1e-15 / 1e-3, level);
      check(SheetMotion<float>(*sheet.grid, mass, {held}, level), 1e-6, level);
    }
  }
}

TEST(SheetMotion, IsGivenBackAsNotANumberWhenItOutrunsItsUnits) {
  // Single precision: 2^31 units for 1.5 times the sheet and what twice its speed reaches.
  const GridTerms sheet({4, 4, true, false, false, false});
  SheetMotion<float> motion(*sheet.grid, Eigen::VectorXd::Ones(sheet.state.x.cols()), {});
  Nodes x = sheet.state.x, v = sheet.state.v;
  motion.load(x, v, 0.01);
  MassForce everywhere;
  everywhere.acceleration = Vec3(0, 0, -1e6);
  motion.leap(0.01, 0.0, everywhere, nullptr);
  motion.store(&x, &v);
  EXPECT_FALSE(x.allFinite());
}

TEST(GridSheet, IsMadeOfUniformNetworksOnly) {
  const TriangleMesh mesh = make_grid(0.3, 0.3, 5, 4);
  SheetStiffness stiffness;
  stiffness.membrane = 100.0;
  const SpringNetwork good = sheet_network(mesh, stiffness);
  EXPECT_TRUE(make_grid_sheet(mesh, good, {}, 0.0, 0));
  const auto refused = [&](auto spoil) {
    SpringNetwork network = good;
    spoil(&network);
    return !make_grid_sheet(mesh, network, {}, 0.0, 0);
  };
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch[3].stiffness *= 1.01; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch[3].rest_length *= 1.01; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch[3].damping = 1.0; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch.pop_back(); }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch[3].b = 12; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->shear.pop_back(); }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->shear[2].stiffness *= 0.9; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->bend[2].stiffness *= 0.9; }));
  EXPECT_TRUE(refused([](SpringNetwork* n) { n->stretch.clear(); }));
  EXPECT_FALSE(make_grid_sheet(mesh, good, {{0, 4, 1.0}}, 0.0, 0)) << "beyond the stencil";
  TriangleMesh no_grid = mesh;
  no_grid.rows = no_grid.cols = 0;
  EXPECT_FALSE(make_grid_sheet(no_grid, good, {}, 0.0, 0));
}

TEST(GridBending, GivesEachPairOfNodesOneWeight) {
  // E = sum w_ij |x_i - x_j|^2 / 2 over pairs i < j in order, at most two cells apart; 3 x 3 and 2 x n are the least.
  for (const auto& [nx, ny] : {std::array<int, 2>{{1, 1}}, {{2, 2}}, {{1, 5}}, {{5, 1}}, {{7, 4}}}) {
    const TriangleMesh mesh = make_grid(0.1 * nx, 0.07 * ny, nx, ny);
    std::array<int, 2> last{{-1, -1}};
    for (const QuadraticWeight& w : grid_bending_weights(mesh, isotropic_bending(0.02, 0.3))) {
      const std::array<int, 2> pair{{w.a, w.b}};
      EXPECT_LT(last, pair) << nx << " x " << ny;
      EXPECT_LT(w.a, w.b);
      const int rows = w.b / mesh.cols - w.a / mesh.cols, cols = std::abs(w.b % mesh.cols - w.a % mesh.cols);
      EXPECT_LE(rows + cols, 2) << nx << " x " << ny << ": " << w.a << ", " << w.b;
      last = pair;
    }
  }
}

TEST(GridBending, HasThePlateEnergyOfUniformCurvatureInAnyDirection) {
  // z = 1/2 (a x^2 + 2 b x y + c y^2): E / A = 1/2 k^T D k, k = (a, c, 2 b), per inner node and cell.
  const TriangleMesh mesh = make_grid(0.6, 0.5, 6, 8);
  BendingMaterial material = isotropic_bending(0.02, 0.3);
  material.weft = 0.015;
  const Mat3 d = plate_stiffness(material);
  const double cell = 0.1 * 0.0625, twisted = 0.6 * 0.5, inner = cell * 5 * 7;
  const double sides_x = cell * 5, sides_y = cell * 7;  // two edges of half weight
  for (const Vec3& k : {Vec3(0.3, 0, 0), Vec3(0, 0.4, 0), Vec3(0, 0, 0.5), Vec3(0.2, -0.3, 0.1), Vec3(0.1, 0.1, 0.2)}) {
    State state;
    state.x = mesh.rest;
    state.v = Nodes::Zero(3, mesh.rest.cols());
    for (Eigen::Index i = 0; i < state.x.cols(); ++i) {
      const double x = mesh.rest(0, i), y = mesh.rest(1, i);
      state.x(2, i) = 0.5 * (k[0] * x * x + k[2] * x * y + k[1] * y * y);
    }
    const auto term = make_quadratic_links("bending", grid_bending_weights(mesh, material), 0.0, 0);
    const double bent = d(0, 0) * k[0] * k[0] + 2.0 * d(0, 1) * k[0] * k[1] + d(1, 1) * k[1] * k[1];
    const double expected = 0.5 * (inner * bent + twisted * d(2, 2) * k[2] * k[2] +
                                   sides_x * (d(0, 0) - d(0, 1) * d(0, 1) / d(1, 1)) * k[0] * k[0] +
                                   sides_y * (d(1, 1) - d(0, 1) * d(0, 1) / d(0, 0)) * k[1] * k[1]);
    // Links are some 1e4 times longer than what they leave of each other.
    EXPECT_NEAR(term->value(state), expected, 1e-10 * expected);
  }
}

}  // namespace
}  // namespace deformable_sim::test
