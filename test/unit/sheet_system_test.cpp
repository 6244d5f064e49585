// The linear system of a sheet on a grid, against the matrix of the terms it stands for.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/grid/sheet_system.h"
#include "support/grid_terms.h"

namespace deformable_sim::test {
namespace {

constexpr double kMass = 1e-3;  // kg
constexpr double kTau = 0.004;  // s

/// Runs at one instruction set.
class AtLevel {
 public:
  explicit AtLevel(SimdLevel level) { setenv("DEFORMABLE_SIM_SIMD", name_of(level), 1); }
  ~AtLevel() { unsetenv("DEFORMABLE_SIM_SIMD"); }
};

/// The system of a sheet, its first and last node of the first row held.
class System {
 public:
  explicit System(const GridTerms& terms) : free(static_cast<size_t>(terms.grid->node_count()), 1), rows(*terms.grid) {
    free[0] = free[static_cast<size_t>(terms.grid->cols - 1)] = 0;
    const std::vector<double> mass(free.size(), kMass);
    system = std::make_unique<SheetSystem>(*terms.grid, mass, free);
    for (int k = 0; k < count(); ++k) system->inertia()[place(k)] = static_cast<float>(kMass / (kTau * kTau));
    system->set_step(kTau, 1.0 / (kTau * kTau), Jacobian::kProjected);
  }
  void linearise(const GridTerms& terms) {
    auto x = rows.make_xyz();
    rows.load(terms.state.x, x.data());
    system->linearise(x.data(), rows.shape());
  }
  int count() const { return static_cast<int>(free.size()); }
  std::ptrdiff_t place(int node) const { return system->rows().place(node); }
  XyzArray<float> make() const { return system->rows().make_xyz(); }
  float* number(XyzArray<float>* of, int node, int axis) const { return number(of->data(), node, axis); }
  float* number(const Xyz<float>& all, int node, int axis) const {
    return (axis == 0 ? all.x : axis == 1 ? all.y : all.z) + place(node);
  }

  std::vector<char> free;
  SheetRows<double> rows;
  std::unique_ptr<SheetSystem> system;
};

/// A random vector over the free nodes, as rows and as columns of all nodes of the terms.
void fill(const System& system, XyzArray<float>* p, Nodes* columns) {
  std::mt19937 random(3);
  std::normal_distribution<float> some;
  columns->setZero();
  for (int k = 0; k < system.count(); ++k) {
    for (int d = 0; d < 3 && system.free[static_cast<size_t>(k)] != 0; ++d) {
      *system.number(p, k, d) = some(random);
      (*columns)(d, GridTerms::kFirst + k) = static_cast<double>(*system.number(p, k, d));
    }
  }
}

double largest_difference(const System& system, XyzArray<float>* y, const Nodes& expected) {
  double most = 0.0;
  for (int k = 0; k < system.count(); ++k) {
    for (int d = 0; d < 3 && system.free[static_cast<size_t>(k)] != 0; ++d) {
      const double found = static_cast<double>(*system.number(y, k, d));
      most = std::max(most, std::abs(found - expected(d, GridTerms::kFirst + k)));
    }
  }
  return most;
}

TEST(SheetSystem, MultipliesAsTheMatrixOfTheTerms) {
  // y = (M / tau^2 - df/dx - (1 / tau) df/dv) p, projected: to single precision, with every feature and width.
  for (const auto& [cells_x, cells_y] : {std::pair(1, 1), {2, 3}, {7, 4}, {16, 2}, {33, 17}}) {
    for (int bits = 0; bits < 16; ++bits) {
      GridTerms terms({cells_x, cells_y, (bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0});
      const BlockMatrix a = terms.matrix(kTau, kMass);
      for (SimdLevel level : levels()) {
        const AtLevel at(level);
        System system(terms);
        system.linearise(terms);
        auto p = system.make(), y = system.make();
        Nodes columns(3, terms.state.x.cols()), expected = columns;
        fill(system, &p, &columns);
        a.multiply(columns, &expected);
        auto turned = system.make();
        const double work = system.system->multiply(p.data(), 0.5f, turned.data(), y.data()),
                     size = expected.cwiseAbs().maxCoeff();
        EXPECT_LT(largest_difference(system, &y, expected), 3e-5 * size) << cells_x << ", " << bits << name_of(level);
        EXPECT_NEAR(work, columns.cwiseProduct(expected).sum(), 1e-5 * columns.norm() * expected.norm());
      }
    }
  }
}

TEST(SheetSystem, AddsCouplings) {
  // A += W^T H W: one node, three with weights, and two against each other.
  GridTerms terms({6, 5, true, false, false, true});
  System system(terms);
  Mat3 h;
  h << 5e4, 1e4, 0, 1e4, 3e4, 2e3, 0, 2e3, 1e4;
  system.system->couplings() = {{{system.place(9), 0, 0}, {1, 0, 0}, 1, h},
                                {{system.place(10), system.place(11), system.place(17)}, {0.5, 0.3, 0.2}, 3, 2 * h},
                                {{system.place(20), system.place(21), 0}, {1, -1, 0}, 2, h}};
  system.linearise(terms);
  auto p = system.make(), y = system.make();
  Nodes columns(3, terms.state.x.cols()), expected = columns;
  fill(system, &p, &columns);
  terms.matrix(kTau, kMass).multiply(columns, &expected);
  const auto column = [](int node) { return GridTerms::kFirst + node; };
  expected.col(column(9)) += h * columns.col(column(9));
  const Vec3 point = 0.5 * columns.col(column(10)) + 0.3 * columns.col(column(11)) + 0.2 * columns.col(column(17));
  expected.col(column(10)) += h * point;
  expected.col(column(11)) += 0.6 * h * point;
  expected.col(column(17)) += 0.4 * h * point;
  const Vec3 pull = h * (columns.col(column(20)) - columns.col(column(21)));
  expected.col(column(20)) += pull;
  expected.col(column(21)) -= pull;
  auto turned = system.make();
  system.system->multiply(p.data(), 0.5f, turned.data(), y.data());
  EXPECT_LT(largest_difference(system, &y, expected), 1e-6 * expected.cwiseAbs().maxCoeff());
}

TEST(SheetSystem, IsPreconditionedBySomethingSymmetricAndDefinite) {
  // B = B^T > 0 over the free nodes, and lambda(B A) within a narrow band: what conjugate gradients ask for.
  GridTerms terms({9, 6, true, true, false, true});
  const BlockMatrix a = terms.matrix(kTau, kMass);
  for (SimdLevel level : levels()) {
    const AtLevel at(level);
    System system(terms);
    system.linearise(terms);
    std::vector<std::array<int, 2>> unknowns;
    for (int k = 0; k < system.count(); ++k) {
      for (int d = 0; d < 3 && system.free[static_cast<size_t>(k)] != 0; ++d) unknowns.push_back({k, d});
    }
    const auto n = static_cast<Eigen::Index>(unknowns.size());
    Eigen::MatrixXd b(n, n), whole(n, n);
    const Eigen::MatrixXd sparse = a.to_sparse();
    for (Eigen::Index j = 0; j < n; ++j) {
      auto r = system.make();
      const auto& [node, axis] = unknowns[static_cast<size_t>(j)];
      *system.number(&r, node, axis) = 1.0f;
      system.system->precondition(r.data());
      const Xyz<float> z = system.system->preconditioned();
      for (Eigen::Index i = 0; i < n; ++i) {
        const auto& [other, other_axis] = unknowns[static_cast<size_t>(i)];
        b(i, j) = static_cast<double>(*system.number(z, other, other_axis));
        whole(i, j) = sparse(3 * (GridTerms::kFirst + other) + other_axis, 3 * (GridTerms::kFirst + node) + axis);
      }
    }
    EXPECT_LT((b - b.transpose()).cwiseAbs().maxCoeff(), 1e-5 * b.cwiseAbs().maxCoeff());
    const Eigen::MatrixXd symmetric = 0.5 * (b + b.transpose());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues()[0], 0.0);
    const Eigen::VectorXd lambda = (b * whole).eigenvalues().real();
    EXPECT_LT(lambda.maxCoeff() / lambda.minCoeff(), 60.0) << name_of(level);
  }
}

TEST(SheetSystem, TakesAsManyIterationsOnFineGridsAsOnCoarseOnes) {
  // Multigrid: the number does not grow with the number of nodes. A sheet of one stiffness and area that bends, held at
  // two corners.
  std::vector<int> taken;
  for (const int cells : {20, 40, 80, 160}) {
    const TriangleMesh mesh = make_grid(1.0, 1.0, cells, cells);
    SheetStiffness stiffness;
    stiffness.stretch = 1000.0;
    stiffness.shear = 200.0;
    const auto bending = grid_bending_weights(mesh, isotropic_bending(1e-5, 0.2));
    const GridSheet sheet = *make_grid_sheet(mesh, sheet_network(mesh, stiffness), bending, 0.01, 0);
    std::vector<double> mass(static_cast<size_t>(sheet.node_count()), 0.2 / sheet.node_count());
    std::vector<char> free(mass.size(), 1);
    free[0] = free[static_cast<size_t>(cells)] = 0;
    SheetSystem system(sheet, mass, free);
    const SheetRows<double> rows(sheet);
    auto x = rows.make_xyz();
    rows.load(1.001 * mesh.rest, x.data());
    for (int k = 0; k < rows.node_count(); ++k) {
      system.inertia()[rows.place(k)] = static_cast<float>(mass[static_cast<size_t>(k)] / (kTau * kTau));
    }
    system.set_step(kTau, 1.0 / (kTau * kTau), Jacobian::kProjected);
    system.linearise(x.data(), rows.shape());
    double squares = 0.0;
    const Xyz<float> r = system.residual();
    for (int k = 0; k < rows.node_count(); ++k) {
      const std::ptrdiff_t at = rows.place(k);
      r.x[at] = r.z[at] = static_cast<float>(1e-5 * (1.0 + mesh.rest(0, k) * mesh.rest(1, k)));
      squares += 2.0 * std::pow(static_cast<double>(r.x[at] * system.weight()[at]), 2);
    }
    LinearReport report;
    system.solve({1e-3, 0.0, 1000}, std::sqrt(squares), 1.0, &report);
    EXPECT_TRUE(report.solved);
    taken.push_back(report.iterations);
  }
  const auto [least, most] = std::minmax_element(taken.begin(), taken.end());
  EXPECT_LE(*most, *least + 3) << taken[0] << " " << taken[1] << " " << taken[2] << " " << taken[3];
  EXPECT_LE(*most, 9);
}

}  // namespace
}  // namespace deformable_sim::test
