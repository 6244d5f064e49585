// Line solves of sheets on grids: the kernels against a dense twin, spring by spring.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "deformable_sim/core/grid/sheet_lines.h"
#include "support/grid_terms.h"

namespace deformable_sim::test {
namespace {

struct TwinSpring {
  int a, b;
  double stiffness, length;
  int number;  // in its line; of diagonals the row
};
using TwinLine = std::vector<TwinSpring>;

/// Every line of one direction: nodes `row_step`, `col_step` apart.
std::vector<TwinLine> lines_of(const GridSheet& g, const GridSprings& springs, int row_step, int col_step) {
  std::vector<TwinLine> lines;
  const auto inside = [&g](int row, int col) { return row >= 0 && row < g.rows && col >= 0 && col < g.cols; };
  for (int row = 0; row < g.rows; ++row) {
    for (int col = 0; col < g.cols; ++col) {
      if (inside(row - row_step, col - col_step)) continue;  // no beginning
      TwinLine line;
      for (int r = row, c = col; inside(r + row_step, c + col_step); r += row_step, c += col_step) {
        const auto u = static_cast<size_t>(r), v = static_cast<size_t>(c);
        const double k = springs.empty() ? g.shear
                         : row_step == 0 ? springs.along[v] * springs.across[u]
                                         : springs.along[u] * springs.across[v];
        line.push_back({r * g.cols + c, (r + row_step) * g.cols + c + col_step, k,
                        springs.empty() ? g.shear_length : springs.length,
                        springs.empty() ? r : static_cast<int>(line.size())});
      }
      if (!line.empty()) lines.push_back(line);
    }
  }
  return lines;
}

/// The same as SheetLines without bending, each line as a dense system in the changes of its tensions.
class Twin {
 public:
  Twin(const GridSheet& grid, LineSolve how, Nodes y, Nodes base, Eigen::VectorXd weight, double tau)
      : grid_(grid),
        x(std::move(y)),
        pull(Nodes::Zero(3, x.cols())),
        base_(std::move(base)),
        weight_(std::move(weight)),
        per_tau_(1.0 / tau) {
    families_.push_back(lines_of(grid, {}, 1, 1));
    families_.push_back(lines_of(grid, {}, 1, -1));
    if (!grid.warp_bend.empty()) families_.push_back(lines_of(grid, grid.warp_bend, 0, 2));
    families_.push_back(lines_of(grid, grid.warp, 0, 1));
    if (!grid.weft_bend.empty()) families_.push_back(lines_of(grid, grid.weft_bend, 2, 0));
    families_.push_back(lines_of(grid, grid.weft, 1, 0));
    for (const auto& family : families_) {
      for (const TwinLine& line : family) tensions_.emplace_back(line.size(), 0.0);
    }
    if (how == LineSolve::kWhole) return;
    // Every spring a line of its own, even ones first.
    tensions_.clear();
    for (auto& family : families_) {
      std::vector<TwinLine> single;
      for (int odd : {0, 1}) {
        for (const TwinLine& line : family) {
          for (const TwinSpring& spring : line) {
            if (spring.number % 2 == odd) single.push_back({spring});
          }
        }
      }
      family = single;
      for (size_t k = 0; k < family.size(); ++k) tensions_.emplace_back(1, 0.0);
    }
  }

  void sweep() {
    size_t k = 0;
    for (const auto& family : families_) {
      for (const TwinLine& line : family) solve(line, &tensions_[k++]);
    }
  }

 private:
  void solve(const TwinLine& line, std::vector<double>* tension) {
    const auto n = static_cast<Eigen::Index>(line.size());
    const double damping = grid_.damping_time * per_tau_;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd rhs(n);
    Nodes direction(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const TwinSpring& s = line[static_cast<size_t>(i)];
      const Vec3 d = x.col(s.b) - x.col(s.a), moved = d - (base_.col(s.b) - base_.col(s.a));
      direction.col(i) = d.normalized();
      a(i, i) = 1.0 / (s.stiffness * (1.0 + damping)) + weight_[s.a] + weight_[s.b];
      if (i > 0) a(i, i - 1) = a(i - 1, i) = -weight_[s.a] * direction.col(i).dot(direction.col(i - 1));
      rhs[i] = (s.stiffness * (d.norm() - s.length) + s.stiffness * damping * direction.col(i).dot(moved) -
                (*tension)[static_cast<size_t>(i)]) /
               (s.stiffness * (1.0 + damping));
    }
    const Eigen::VectorXd change = a.ldlt().solve(rhs);
    for (Eigen::Index i = 0; i < n; ++i) {
      const TwinSpring& s = line[static_cast<size_t>(i)];
      (*tension)[static_cast<size_t>(i)] += change[i];
      const Vec3 f = change[i] * direction.col(i);
      x.col(s.a) += weight_[s.a] * f;
      x.col(s.b) -= weight_[s.b] * f;
      pull.col(s.a) += f;
      pull.col(s.b) -= f;
    }
  }

  const GridSheet& grid_;
  std::vector<std::vector<TwinLine>> families_;
  std::vector<std::vector<double>> tensions_;

 public:
  Nodes x, pull;

 private:
  Nodes base_;
  Eigen::VectorXd weight_;
  double per_tau_;
};

constexpr double kTau = 2e-3, kWeight = 4e-4;

/// Weights that differ, two nodes held.
Eigen::VectorXd some_weights(const GridSheet& grid, Eigen::Index nodes, std::vector<int>* held) {
  *held = {grid.first_node, grid.first_node + grid.node_count() / 2};
  Eigen::VectorXd weight(nodes);
  for (Eigen::Index i = 0; i < nodes; ++i) weight[i] = kWeight * (1.0 + 0.3 * std::sin(static_cast<double>(i)));
  for (int node : *held) weight[node] = 0.0;
  return weight;
}

template <class Real>
void expect_twin(const GridTerms& sheet, LineSolve how, int sweeps, double tolerance) {
  const GridSheet& grid = *sheet.grid;
  const Eigen::Index n = sheet.state.x.cols();
  std::vector<int> held;
  const Eigen::VectorXd weight = some_weights(grid, n, &held);
  const Nodes base = sheet.state.x - 1e-3 * sheet.state.v;
  SheetLines<Real> lines(grid, held, how);
  lines.begin(sheet.state.x, base, weight, kTau);
  const int first = grid.first_node, count = grid.node_count();
  Twin twin(grid, how, sheet.state.x.middleCols(first, count), base.middleCols(first, count),
            weight.segment(first, count), kTau);
  for (int k = 1; k <= sweeps; ++k) {
    lines.sweep(k == sweeps ? SheetLines<Real>::Last::kYes : SheetLines<Real>::Last::kNo);
    twin.sweep();
  }
  Nodes x = sheet.state.x;
  lines.store(&x);
  EXPECT_LT((x.middleCols(first, count) - twin.x).cwiseAbs().maxCoeff(), tolerance) << sweeps;
  Nodes forces = Nodes::Zero(3, 2);
  lines.add_held_forces(&forces);
  for (Eigen::Index k = 0; k < 2; ++k) {
    const Vec3 expected = twin.pull.col(held[static_cast<size_t>(k)] - first);
    EXPECT_LT((forces.col(k) - expected).norm(), tolerance / kWeight) << sweeps;
  }
}

TEST(SheetLines, SolveEveryLineAsItsDenseSystem) {
  // (1 / K + G W G^T) dt = (t(x) - t) / K line by line: rounding only, in each precision; sizes around a register, with
  // every feature; once and again from the tensions at hand; whole lines, and spring by spring.
  for (const auto& [cells_x, cells_y] : {std::pair(1, 1), {2, 3}, {7, 4}, {15, 9}, {16, 2}, {33, 17}, {5, 34}}) {
    for (int bits = 0; bits < 4; ++bits) {
      const GridTerms sheet({cells_x, cells_y, true, (bits & 1) != 0, (bits & 2) != 0, false});
      SCOPED_TRACE(std::to_string(cells_x) + " x " + std::to_string(cells_y) + ", " + std::to_string(bits));
      for (int sweeps : {1, 3}) {
        for (LineSolve how : {LineSolve::kWhole, LineSolve::kSpringBySpring}) {
          expect_twin<double>(sheet, how, sweeps, 1e-12);
          expect_twin<float>(sheet, how, sweeps, 2e-5);
        }
      }
    }
  }
}

TEST(SheetLines, AreTheSameAtEveryWidth) {
  // What the machine has is used by SheetLines; the other levels' kernels solve a line of one direction alike.
  const GridTerms sheet({20, 18, true, true, false, false});
  SheetRows<double> rows(*sheet.grid);
  const SheetShape<double>& s = rows.shape();
  std::vector<Nodes> ends;
  for (SimdLevel level : levels()) {
    const LineKernels<double>& kernels = line_kernels(level, 0.0);
    auto x = rows.make_xyz(), base = rows.make_xyz(), pull = rows.make_xyz();
    auto weight = rows.make_array();
    rows.load(sheet.state.x, x.data());
    rows.load(sheet.state.x - 1e-3 * sheet.state.v, base.data());
    for (int node = 0; node < rows.node_count(); ++node) weight.data()[rows.place(node)] = kWeight;
    std::vector<double> space(static_cast<size_t>(LineMotion<double>::kNumbers * kernels.width * s.rows));
    const std::vector<unsigned char> keeps(static_cast<size_t>(s.rows), 0);
    const LineMotion<double> motion{x.data(), weight.data(), base.data(), 0.5, pull.data(), space.data()};
    GridLines<double> lines{s.stride, s.weft_along, 1, nullptr, 0, s.weft_length, nullptr, keeps.data()};
    for (int col = 0; col < s.cols; col += kernels.width) {
      lines.across = s.weft_across + col;
      kernels.solve(lines, motion, col, 0, s.rows - 1, true);
    }
    ends.push_back(Nodes::Zero(3, sheet.state.x.cols()));
    rows.store(x.data(), &ends.back());
    EXPECT_GT((ends.back() - sheet.state.x).norm(), 1e-3);
    EXPECT_LT((ends.back() - ends.front()).cwiseAbs().maxCoeff(), 1e-13) << name_of(level);
  }
}

TEST(SheetLines, TurnASheetOverAndBack) {
  const int rows = 21, cols = 35;
  for (SimdLevel level : levels()) {
    const LineKernels<float>& kernels = line_kernels(level, 0.0f);
    RowArray<float> from(48, 64), to(48, 64), back(48, 64);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c) from.data()[64 * r + c] = static_cast<float>(100 * r + c);
    }
    kernels.transpose(from.data(), 64, rows, cols, to.data(), 64);
    kernels.transpose(to.data(), 64, cols, rows, back.data(), 64);
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < cols; ++c) {
        ASSERT_EQ(to.data()[64 * c + r], static_cast<float>(100 * r + c)) << name_of(level);
        ASSERT_EQ(back.data()[64 * r + c], static_cast<float>(100 * r + c)) << name_of(level);
      }
    }
  }
}

TEST(SheetLines, BendImplicitlyToATwentieth) {
  // (1 / w + (1 + b / tau) K) z = -K (y + b (y - base) / tau), against a dense solution; springs that are next to
  // nothing.
  for (const double tau : {1e-3, 2e-2}) {
    GridTerms sheet({12, 9, false, false, false, true});
    GridSheet grid = *sheet.grid;
    for (GridSprings* springs : {&grid.warp, &grid.weft}) {
      for (double& k : springs->along) k *= 1e-12;
    }
    const Eigen::Index n = grid.node_count(), first = grid.first_node;
    std::vector<int> held;
    const Eigen::VectorXd weight = some_weights(grid, sheet.state.x.cols(), &held);
    const Nodes base = sheet.state.x - tau * sheet.state.v;
    const double lag = grid.bending_damping / tau;
    // K from its forces at unit displacements.
    Eigen::MatrixXd k(n, n);
    State unit;
    unit.v = Nodes::Zero(3, sheet.state.x.cols());
    for (Eigen::Index j = 0; j < n; ++j) {
      unit.x = unit.v;
      unit.x(0, first + j) = 1.0;
      Nodes f = unit.v;
      sheet.terms.back()->add_force(unit, &f);
      k.col(j) = -f.row(0).segment(first, n).transpose();
    }
    const Nodes y = (sheet.state.x + lag * (sheet.state.x - base)).middleCols(first, n);
    const Eigen::VectorXd w = weight.segment(first, n);
    const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(n, n) + w.asDiagonal() * k * (1.0 + lag);
    const Eigen::MatrixXd exact = a.lu().solve(-(w.asDiagonal() * k) * y.transpose());
    SheetLines<double> lines(grid, held);
    lines.begin(sheet.state.x, base, weight, tau);
    lines.sweep(SheetLines<double>::Last::kYes);
    Nodes x = sheet.state.x;
    lines.store(&x);
    const Eigen::MatrixXd found = (x - sheet.state.x).middleCols(first, n).transpose();
    EXPECT_GT(exact.norm(), 1e-3);
    EXPECT_LT((found - exact).norm(), 0.05 * exact.norm()) << tau;
  }
}

}  // namespace
}  // namespace deformable_sim::test
