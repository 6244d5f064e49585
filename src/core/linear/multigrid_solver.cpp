#include "deformable_sim/core/linear/multigrid_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deformable_sim/core/linear/aggregation_multigrid.h"

namespace deformable_sim {
namespace {

constexpr float kSmoothing = 0.65f;        // as in ConjugateGradient
constexpr double kSinglePrecision = 1e-4;  // the reduction asked of one pass in single precision
constexpr double kWeight = 0.5;            // of a link's stiffness in the scalar operator, see ScalarFactor
// The coarse levels are renewed when more than one row sum in this many has changed by more than the ratio.
constexpr int kStaleShare = 12;
constexpr float kStaleRatio = 2.0f;
constexpr double kOtherStiffness = 1.5;  // a Laplacian that has changed by more is made anew

/// 0.65 A^-1 by columns, A symmetric to rounding, also by columns.
void invert(const float* a, float diagonal, float* inverse) {
  const float xx = a[0] + diagonal, yy = a[4] + diagonal, zz = a[8] + diagonal;
  const float xy = 0.5f * (a[1] + a[3]), xz = 0.5f * (a[2] + a[6]), yz = 0.5f * (a[5] + a[7]);
  const float c_xx = yy * zz - yz * yz, c_xy = xz * yz - xy * zz, c_xz = xy * yz - xz * yy;
  const float scale = kSmoothing / (xx * c_xx + xy * c_xy + xz * c_xz);
  inverse[0] = scale * c_xx;
  inverse[4] = scale * (xx * zz - xz * xz);
  inverse[8] = scale * (xx * yy - xy * xy);
  inverse[1] = inverse[3] = scale * c_xy;
  inverse[2] = inverse[6] = scale * c_xz;
  inverse[5] = inverse[7] = scale * (xy * xz - xx * yz);
}

/// Nodes breadth first from a node of least degree, so that neighbours lie near each other in memory [Cuthill 1969].
std::vector<int> breadth_first(const BlockMatrix& a) {
  const auto degree = [&](int i) {
    return a.row_start()[static_cast<size_t>(i) + 1] - a.row_start()[static_cast<size_t>(i)];
  };
  std::vector<int> starts(static_cast<size_t>(a.rows())), order, next;
  for (int i = 0; i < a.rows(); ++i) starts[static_cast<size_t>(i)] = i;
  std::stable_sort(starts.begin(), starts.end(), [&](int i, int j) { return degree(i) < degree(j); });
  std::vector<char> seen(starts.size(), 0);
  for (int start : starts) {
    if (seen[static_cast<size_t>(start)] != 0) continue;
    seen[static_cast<size_t>(start)] = 1;
    order.push_back(start);
    for (size_t k = order.size() - 1; k < order.size(); ++k) {
      next.clear();
      const auto i = static_cast<size_t>(order[k]);
      for (int slot = a.row_start()[i]; slot < a.row_start()[i + 1]; ++slot) {
        const int j = a.column()[static_cast<size_t>(slot)];
        if (seen[static_cast<size_t>(j)] != 0) continue;
        seen[static_cast<size_t>(j)] = 1;
        next.push_back(j);
      }
      std::stable_sort(next.begin(), next.end(), [&](int p, int q) { return degree(p) < degree(q); });
      order.insert(order.end(), next.begin(), next.end());
    }
  }
  return order;
}

class Solver : public MultigridSolver {
 public:
  Solver() : kernels_(block_kernels(simd_level())), coarse_(kernels_) {}

  void set_links(const std::vector<const ConstantLinks*>& links, double tau, const std::vector<int>& held) override {
    links_ = links;
    link_tau_ = tau;
    held_nodes_ = held;
  }

  void forget() override { stiffness_ = 0.0; }

  void prepare(const BlockMatrix& a) override {
    const bool same = a.row_start() == pattern_rows_ && a.column() == pattern_columns_ && held_nodes_ == laid_out_held_;
    if (!same) lay_out(a);
    lay_out_links(a.rows());
    const double stiffness = total_weight(a);
    if (same && stiffness < kOtherStiffness * stiffness_ && stiffness_ < kOtherStiffness * stiffness) return;
    stiffness_ = stiffness;
    coarse_.prepare(laplacian_of(a));
    refreshed_.setZero();
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                     const LinearTolerance& tolerance, Nodes* x) override {
    load(a);
    for (size_t p = 0; p < node_.size(); ++p) weight_[p] = static_cast<float>(weight[node_[p]]);
    LinearReport report;
    definite_ = true;
    residual_ = b;
    if (!x->isZero(0.0)) subtract_product(a, *x);
    double norm = rms(residual_, weight);
    const double goal = std::max(tolerance.absolute, tolerance.relative * rms(b, weight));
    while (norm > goal && report.iterations < tolerance.iterations) {
      const double reduction = std::max(goal / norm * 0.9, kSinglePrecision);
      report.iterations += pass(reduction, tolerance.iterations - report.iterations);
      for (size_t p = 0; p < node_.size(); ++p) {
        x->col(node_[p]) += sum_.col(static_cast<Eigen::Index>(p)).head<3>().cast<double>() * unit_;
      }
      report.definite = definite_;
      if (reduction > kSinglePrecision && report.iterations < tolerance.iterations) return report;
      residual_ = b;
      subtract_product(a, *x);
      const double last = norm;
      norm = rms(residual_, weight);
      if (!(norm < 0.5 * last)) break;  // round-off, or a matrix that is not definite
    }
    report.solved = norm <= goal;
    return report;
  }

 private:
  static double rms(const Nodes& r, const Eigen::VectorXd& weight) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < r.cols(); ++i) sum += r.col(i).squaredNorm() * weight[i] * weight[i];
    return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(1, r.cols())));
  }

  bool is_held(int position) const { return held_[static_cast<size_t>(position)] != 0; }
  double link_factor(const ConstantLinks& links) const { return 1.0 + links.damping / link_tau_; }

  /// Rows in the solver's own order.
  void lay_out(const BlockMatrix& a) {
    pattern_rows_ = a.row_start();
    pattern_columns_ = a.column();
    laid_out_held_ = held_nodes_;
    const auto n = static_cast<size_t>(a.rows());
    node_ = breadth_first(a);
    position_.resize(n);
    for (size_t p = 0; p < n; ++p) position_[static_cast<size_t>(node_[p])] = static_cast<int>(p);
    held_.assign(n, 0);
    for (int node : held_nodes_) held_[static_cast<size_t>(position_[static_cast<size_t>(node)])] = 1;
    start_.assign(1, 0);
    column_.clear();
    slot_.clear();
    diagonal_.resize(n);
    std::vector<std::array<int, 2>> row;
    for (size_t p = 0; p < n; ++p) {
      const auto i = static_cast<size_t>(node_[p]);
      row.clear();
      for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
        row.push_back({position_[static_cast<size_t>(a.column()[static_cast<size_t>(k)])], k});
      }
      std::sort(row.begin(), row.end());
      for (const auto& [column, slot] : row) {
        if (column == static_cast<int>(p)) diagonal_[p] = static_cast<int>(column_.size());
        column_.push_back(column);
        slot_.push_back(slot);
      }
      start_.push_back(static_cast<int>(column_.size()));
    }
    blocks_.assign(9 * column_.size() + 3, 0.0f);
    inverse_.assign(9 * n + 3, 0.0f);
    weight_.resize(n);
    for (AxisValues* values : {&row_sum_, &refreshed_}) values->setZero(4, a.rows());
    for (PaddedNodes* m : {&r_, &z_, &p_, &q_, &t_, &correction_, &sum_}) m->setZero(4, a.rows());
    residual_.setZero(3, a.rows());
    product_.setZero(3, a.rows());
  }

  /// All links together. Nodes that are held take part in neither row nor column.
  void lay_out_links(int rows) {
    link_start_.clear();
    link_column_.clear();
    link_value_.clear();
    link_sum_.assign(static_cast<size_t>(rows), 0.0f);
    if (links_.empty()) return;
    link_start_.assign(1, 0);
    std::vector<std::array<double, 2>> row;
    for (size_t p = 0; p < node_.size(); ++p) {
      row.clear();
      for (const ConstantLinks* links : links_) {
        const int i = node_[p] - links->first_node;
        if (i < 0 || i >= links->rows() || held_[p] != 0) continue;
        link_sum_[p] += static_cast<float>(link_factor(*links) * links->sum[static_cast<size_t>(i)]);
        for (int k = links->row_start[static_cast<size_t>(i)]; k < links->row_start[static_cast<size_t>(i) + 1]; ++k) {
          const int j = links->first_node + links->column[static_cast<size_t>(k)];
          const int column = position_[static_cast<size_t>(j)];
          if (is_held(column)) continue;
          row.push_back({static_cast<double>(column), link_factor(*links) * links->stiffness[static_cast<size_t>(k)]});
        }
      }
      std::sort(row.begin(), row.end());
      for (const auto& [column, value] : row) {
        link_column_.push_back(static_cast<int>(column));
        link_value_.push_back(static_cast<float>(value));
      }
      link_start_.push_back(static_cast<int>(link_column_.size()));
    }
  }

  double total_weight(const BlockMatrix& a) const {
    double sum = 0.0;
    for (size_t p = 0; p < node_.size(); ++p)
      for (int k = start_[p]; k < start_[p + 1]; ++k)
        if (k != diagonal_[p]) sum += a.block(slot_[static_cast<size_t>(k)]).norm();
    return sum;
  }

  /// A graph Laplacian in the solver's own order: of a block, and so of k n n^T, kWeight times the norm.
  GraphMatrix laplacian_of(const BlockMatrix& a) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int p = 0; p < a.rows(); ++p) {
      double degree = 0.0;
      for (int k = start_[static_cast<size_t>(p)]; k < start_[static_cast<size_t>(p) + 1]; ++k) {
        const int column = column_[static_cast<size_t>(k)];
        const double weight = kWeight * a.block(slot_[static_cast<size_t>(k)]).norm();
        if (column == p || weight == 0.0) continue;
        degree += weight;
        entries.emplace_back(p, column, -weight);
      }
      entries.emplace_back(p, p, degree);
    }
    GraphMatrix laplacian(a.rows(), a.rows());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
  }

  /// Single precision copy, inverse diagonal blocks, and new coarse levels if contacts have changed.
  void load(const BlockMatrix& a) {
    int stale = 0;
    for (size_t p = 0; p < node_.size(); ++p) {
      Vec3 sum = Vec3::Zero();
      for (int k = start_[p]; k < start_[p + 1]; ++k) {
        const Mat3& block = a.block(slot_[static_cast<size_t>(k)]);
        sum += block.diagonal();
        float* to = blocks_.data() + 9 * k;
        for (int e = 0; e < 9; ++e) to[e] = static_cast<float>(block.data()[e]);
      }
      invert(blocks_.data() + 9 * diagonal_[p], link_sum_[p], inverse_.data() + 9 * p);
      const auto column = static_cast<Eigen::Index>(p);
      row_sum_.col(column).head<3>() = sum.cwiseMax(0.0).cast<float>();
      const auto now = row_sum_.col(column).head<3>().array(), then = refreshed_.col(column).head<3>().array();
      if ((now > kStaleRatio * then).any() || (kStaleRatio * now < then).any()) ++stale;
    }
    if (stale * kStaleShare <= a.rows() && refreshed_(0, 0) > 0.0f) return;
    refreshed_ = row_sum_;
    coarse_works_ = coarse_.refresh(row_sum_) && !coarse_.empty();
  }

  /// z_ = M^-1 r_; returns r.z.
  double precondition() {
    const int n = static_cast<int>(node_.size());
    kernels_.sweep(n, inverse_.data(), r_.data(), z_.data());
    if (!coarse_works_) return dot(r_, z_);
    const BlockRows a = rows();
    kernels_.residue(a, r_.data(), z_.data(), t_.data());
    coarse_.correct(t_, &correction_);
    return kernels_.correct(a, inverse_.data(), t_.data(), correction_.data(), r_.data(), z_.data());
  }

  /// One pass from zero on residual_: sum_ * unit_ is the correction. Returns the iterations spent.
  int pass(double reduction, int most) {
    const int n = static_cast<int>(node_.size());
    unit_ = residual_.cwiseAbs().maxCoeff();  // keeps single precision far from its ends
    double squares = 0.0;
    for (size_t p = 0; p < node_.size(); ++p) {
      const auto column = static_cast<Eigen::Index>(p);
      r_.col(column).head<3>() = (residual_.col(node_[p]) / unit_).cast<float>();
      squares += static_cast<double>((weight_[p] * r_.col(column)).squaredNorm());
    }
    sum_.setZero();
    const double goal = reduction * reduction * squares;
    const BlockRows a = rows();
    const LinkRows<float> links{link_start_.empty() ? 0 : n, link_start_.data(), link_column_.data(),
                                link_value_.data(), link_sum_.data()};
    double rz = 0.0;
    for (int iteration = 1; iteration <= most; ++iteration) {
      const double rz_new = precondition();
      definite_ = definite_ && rz_new >= 0.0;
      if (!(rz_new > 0.0)) return iteration;
      kernels_.direct(n, z_.data(), iteration == 1 ? 0.0f : static_cast<float>(rz_new / rz), p_.data());
      rz = rz_new;
      const double curvature = kernels_.product(a, links, p_.data(), q_.data());
      definite_ = definite_ && curvature > 0.0;
      if (!(curvature > 0.0)) return iteration;
      const auto alpha = static_cast<float>(rz / curvature);
      const double left = kernels_.advance(n, alpha, p_.data(), q_.data(), weight_.data(), sum_.data(), r_.data());
      if (left <= goal) return iteration;
    }
    return most;
  }

  BlockRows rows() const { return {static_cast<int>(node_.size()), start_.data(), column_.data(), blocks_.data()}; }

  static double dot(const PaddedNodes& a, const PaddedNodes& b) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.cols(); ++i) sum += static_cast<double>(a.col(i).dot(b.col(i)));
    return sum;
  }

  /// residual_ -= (A + links) x in double precision.
  void subtract_product(const BlockMatrix& a, const Nodes& x) {
    a.multiply(x, &product_);
    residual_ -= product_;
    for (const ConstantLinks* links : links_) {
      const double factor = link_factor(*links);
      for (int i = 0; i < links->rows(); ++i) {
        const int node = links->first_node + i;
        if (is_held(position_[static_cast<size_t>(node)])) continue;
        Vec3 sum = links->sum[static_cast<size_t>(i)] * x.col(node);
        for (int k = links->row_start[static_cast<size_t>(i)]; k < links->row_start[static_cast<size_t>(i) + 1]; ++k) {
          const int other = links->first_node + links->column[static_cast<size_t>(k)];
          if (is_held(position_[static_cast<size_t>(other)])) continue;
          sum -= links->stiffness[static_cast<size_t>(k)] * x.col(other);
        }
        residual_.col(node) -= factor * sum;
      }
    }
  }

  const BlockKernels& kernels_;
  AggregationMultigrid coarse_;
  bool coarse_works_ = false;

  // In the solver's own order.
  std::vector<int> pattern_rows_, pattern_columns_, laid_out_held_;
  double stiffness_ = 0.0;            // of all links of the coarse levels, N/m
  std::vector<int> node_, position_;  // node at a position, position of a node
  std::vector<char> held_;            // by position
  std::vector<int> start_, column_, slot_, diagonal_;
  std::vector<float> blocks_;   // of the matrix, nine floats each, by columns
  std::vector<float> inverse_;  // of the diagonal blocks, times the smoothing weight
  std::vector<float> weight_;
  AxisValues row_sum_, refreshed_;  // of the matrix at hand and of the coarse levels
  PaddedNodes r_, z_, p_, q_, t_, correction_, sum_;

  // Constant links, all together.
  std::vector<const ConstantLinks*> links_;
  double link_tau_ = 1.0;
  std::vector<int> held_nodes_;
  std::vector<int> link_start_, link_column_;
  std::vector<float> link_value_, link_sum_;

  Nodes residual_, product_;
  double unit_ = 1.0;
  bool definite_ = true;  // as far as this solve has seen
};

}  // namespace

std::unique_ptr<MultigridSolver> make_multigrid_solver() {
  return std::make_unique<Solver>();
}

}  // namespace deformable_sim
