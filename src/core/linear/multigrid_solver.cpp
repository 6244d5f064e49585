#include "deformable_sim/core/linear/multigrid_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deformable_sim/core/linear/aggregation_multigrid.h"
#include "deformable_sim/core/linear/kept_links.h"
#include "deformable_sim/core/linear/node_couplings.h"
#include "deformable_sim/core/linear/packet_kernels.h"
#include "deformable_sim/core/linear/row_order.h"
#include "deformable_sim/core/linear/row_packets.h"
#include "deformable_sim/core/linear/spring_rows.h"

namespace deformable_sim {
namespace {

constexpr double kDigits = 1e-4;     // relative residual that single precision can give
constexpr float kSmoothing = 0.65f;  // weight of a sweep, at most ...
constexpr float kBelowLimit = 1.7f;  // ... and this over lambda_max as so many powers of D^-1 A find it, too low
constexpr int kPowers = 15;
constexpr double kWeight = 0.5;  // of a link's stiffness in the scalar operator, see ScalarFactor
// The coarse levels are renewed when more than one row sum in this many has changed by more than the ratio.
constexpr int kStaleShare = 12;
constexpr float kStaleRatio = 2.0f;
constexpr double kOtherStiffness = 1.5;  // a Laplacian that has changed by more is made anew

using Neighbours = std::vector<std::vector<int>>;

class Solver : public MultigridSolver {
 public:
  Solver() : kernels_(block_kernels(simd_level())), packets_(packet_kernels(simd_level())), coarse_(kernels_) {}

  void set_links(const std::vector<const ConstantLinks*>& links, double tau, const std::vector<int>& held) override {
    links_.set(links);
    link_tau_ = tau;
    held_nodes_ = held;
  }

  void set_springs(const std::vector<SpringElement>& springs) override {
    if (springs_.set(springs)) laid_out_springs_ = false;
  }

  void place_springs(const Nodes& x, double dx, double dv, Transverse transverse) override {
    springs_.place(x, dx, dv, transverse == Transverse::kProjected ? 1.0 : 0.0);
  }

  void forget() override { stiffness_ = weight_tau_ = 0.0; }

  void prepare(const BlockMatrix& a) override {
    const bool same = laid_out_springs_ && a.row_start() == pattern_rows_ && a.column() == pattern_columns_ &&
                      held_nodes_ == laid_out_held_;
    if (!same) lay_out(a);
    links_.scale(link_tau_);
    // A shorter step makes lambda_max smaller.
    if (!same || link_tau_ > weight_tau_) set_weight(a);
    const double stiffness = total_weight(a);
    if (same && stiffness < kOtherStiffness * stiffness_ && stiffness_ < kOtherStiffness * stiffness) return;
    stiffness_ = stiffness;
    coarse_.prepare(laplacian_of(a));
    refreshed_.setZero();
  }

  bool take(const NodeCouplings* couplings) override {
    couplings_ = couplings;
    return true;
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                     const LinearTolerance& tolerance, Nodes* x) override {
    load(a);
    double squares = 0.0;
    for (size_t p = 0; p < node_.size(); ++p) {
      weight_[p] = static_cast<float>(weight[node_[p]]);
      squares += weight[node_[p]] * weight[node_[p]] * b.col(node_[p]).squaredNorm();
    }
    LinearReport report;
    definite_ = true;
    const double norm = std::sqrt(squares / static_cast<double>(std::max<size_t>(1, node_.size())));
    const double goal = std::max(tolerance.absolute, std::max(tolerance.relative, kDigits) * norm);
    if (norm <= goal) return report;
    unit_ = b.cwiseAbs().maxCoeff();  // keeps single precision far from its ends
    const double enough = goal / norm * (goal / norm) * squares / (unit_ * unit_);
    report.iterations = iterate(b, enough, tolerance.iterations, &report.solved);
    for (size_t p = 0; p < node_.size(); ++p) {
      x->col(node_[p]) += sum_.col(static_cast<Eigen::Index>(p)).head<3>().cast<double>() * unit_;
    }
    report.definite = definite_;
    return report;
  }

 private:
  bool is_held(int position) const { return held_[static_cast<size_t>(position)] != 0; }

  /// Rows in the solver's own order.
  void lay_out(const BlockMatrix& a) {
    pattern_rows_ = a.row_start();
    pattern_columns_ = a.column();
    laid_out_held_ = held_nodes_;
    laid_out_springs_ = true;
    const auto n = static_cast<size_t>(a.rows());
    const Neighbours neighbours = neighbours_of(a);
    node_ = breadth_first(neighbours);
    sort_by_length(neighbours);
    position_.resize(n);
    for (size_t p = 0; p < n; ++p) position_[static_cast<size_t>(node_[p])] = static_cast<int>(p);
    held_.assign(n, 0);
    for (int node : held_nodes_) held_[static_cast<size_t>(position_[static_cast<size_t>(node)])] = 1;
    pack_blocks(a);
    springs_.pack(position_, held_, packets_.width);
    links_.pack(position_, held_, packets_.width);
    const auto padded = static_cast<Eigen::Index>(packets()) * packets_.width;
    inverse_.assign(static_cast<size_t>(6 * padded), 0.0f);
    weight_.resize(n);
    for (AxisValues* values : {&row_sum_, &refreshed_}) values->setZero(4, padded);
    for (PaddedNodes* m : {&r_, &z_, &p_, &q_, &t_, &correction_, &sum_}) m->setZero(4, padded);
  }

  int packets() const { return (static_cast<int>(node_.size()) + packets_.width - 1) / packets_.width; }

  /// Rows of blocks in packets, the diagonal first.
  void pack_blocks(const BlockMatrix& a) {
    std::vector<int> length;
    for (int i : node_) {
      const auto k = static_cast<size_t>(i);
      length.push_back(a.row_start()[k + 1] - a.row_start()[k]);
    }
    rows_.lay_out(length, packets_.width);
    slot_.assign(rows_.size(), -1);
    blocks_.assign(9 * rows_.size(), 0.0f);
    std::vector<std::array<int, 2>> row;
    for (int p = 0; p < a.rows(); ++p) {
      const int i = node_[static_cast<size_t>(p)];
      row.clear();
      for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
        const int column = a.column()[static_cast<size_t>(k)];
        row.push_back({column == i ? -1 : position_[static_cast<size_t>(column)], k});
      }
      std::sort(row.begin(), row.end());
      for (size_t k = 0; k < row.size(); ++k) {
        const auto entry = static_cast<int>(k);
        if (row[k][0] >= 0) rows_.set_column(p, entry, row[k][0]);
        slot_[rows_.at(p, entry)] = row[k][1];
      }
    }
  }

  Neighbours neighbours_of(const BlockMatrix& a) const {
    Neighbours neighbours(static_cast<size_t>(a.rows()));
    for (size_t i = 0; i < neighbours.size(); ++i) {
      neighbours[i].assign(a.column().begin() + a.row_start()[i], a.column().begin() + a.row_start()[i + 1]);
    }
    for (const SpringElement& s : springs_.springs()) {
      neighbours[static_cast<size_t>(s.a)].push_back(s.b);
      neighbours[static_cast<size_t>(s.b)].push_back(s.a);
    }
    return neighbours;
  }

  void sort_by_length(const Neighbours& neighbours) {
    std::vector<int> length = links_.counts(node_.size());
    for (size_t i = 0; i < node_.size(); ++i) length[i] += 1024 * static_cast<int>(neighbours[i].size());
    sort_in_windows([&](int i) { return length[static_cast<size_t>(i)]; }, &node_);
  }

  double total_weight(const BlockMatrix& a) const {
    double sum = 0.0;
    for (int k = 0; k < a.block_count(); ++k) sum += a.block(k).norm();
    for (int i = 0; i < a.rows(); ++i) sum -= a.block(a.diagonal_slot(i)).norm();
    for (const SpringElement& s : springs_.springs()) sum += 2.0 * springs_.norm_of(s);
    return sum;
  }

  /// A graph Laplacian in the solver's own order: of a block, and so of k n n^T, kWeight times the norm.
  GraphMatrix laplacian_of(const BlockMatrix& a) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int p = 0; p < a.rows(); ++p) {
      double degree = 0.0;
      const auto i = static_cast<size_t>(node_[static_cast<size_t>(p)]);
      for (int k = a.row_start()[i]; k < a.row_start()[i + 1]; ++k) {
        const int column = position_[static_cast<size_t>(a.column()[static_cast<size_t>(k)])];
        const double weight = kWeight * a.block(k).norm();
        if (column == p || weight == 0.0) continue;
        degree += weight;
        entries.emplace_back(p, column, -weight);
      }
      entries.emplace_back(p, p, degree);
    }
    for (const SpringElement& s : springs_.springs()) {
      const int p = position_[static_cast<size_t>(s.a)], q = position_[static_cast<size_t>(s.b)];
      if (is_held(p) || is_held(q)) continue;
      const double weight = kWeight * springs_.norm_of(s);
      entries.emplace_back(p, p, weight);
      entries.emplace_back(q, q, weight);
      entries.emplace_back(p, q, -weight);
      entries.emplace_back(q, p, -weight);
    }
    GraphMatrix laplacian(a.rows(), a.rows());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    return laplacian;
  }

  /// Sweeps converge, and the preconditioner is definite, while their weight is below 2 / lambda_max(D^-1 A): 2 to 3 of
  /// springs and membranes, more of plates and quadratic elements.
  void set_weight(const BlockMatrix& a) {
    weight_tau_ = link_tau_;
    weight_of_sweep_ = 1.0f;
    copy(a);
    z_.setZero();
    for (Eigen::Index p = 0; p < a.rows(); ++p) {
      for (int axis = 0; axis < 3; ++axis) z_(axis, p) = std::sin(static_cast<float>(7 * p + 3 * axis) * 1.3f);
    }
    z_.normalize();
    r_.setZero();
    float largest = 0.0f;
    for (int k = 0; k < kPowers; ++k) {
      packets_.residue(matrix(), r_.data(), z_.data(), t_.data());
      packets_.sweep(packets(), inverse_.data(), t_.data(), z_.data());
      largest = z_.norm();
      z_ /= largest;
    }
    weight_of_sweep_ = std::min(kSmoothing, kBelowLimit / largest);
  }

  void copy(const BlockMatrix& a) {
    packets_.load(matrix(), {slot_.data(), a.block(0).data()}, springs_.source(node_), links_.rows().diagonal,
                  weight_of_sweep_, blocks_.data(), springs_.blocks(), inverse_.data(), row_sum_.data());
  }

  /// Single precision copy, inverse diagonal blocks, and new coarse levels if contacts have changed.
  void load(const BlockMatrix& a) {
    copy(a);
    row_sum_ = row_sum_.cwiseMax(0.0f);
    int stale = 0;
    for (Eigen::Index p = 0; p < a.rows(); ++p) {
      const auto now = row_sum_.col(p).array(), then = refreshed_.col(p).array();
      if ((now > kStaleRatio * then).any() || (kStaleRatio * now < then).any()) ++stale;
    }
    if (stale * kStaleShare <= a.rows() && refreshed_(0, 0) > 0.0f) return;
    refreshed_ = row_sum_;
    coarse_works_ = coarse_.refresh(row_sum_) && !coarse_.empty();
  }

  /// z_ = M^-1 r_; returns r.z.
  double precondition() {
    packets_.sweep(packets(), inverse_.data(), r_.data(), z_.data());
    if (!coarse_works_) return dot(r_, z_);
    const PacketMatrix a = matrix();
    packets_.residue(a, r_.data(), z_.data(), t_.data());
    coarse_.correct(t_, &correction_);
    return packets_.correct(a, inverse_.data(), t_.data(), correction_.data(), r_.data(), z_.data());
  }

  /// From zero until the sum of weighted squares of r_ is `enough`: sum_ * unit_ is the solution. Returns the
  /// iterations spent.
  int iterate(const Nodes& b, double enough, int most, bool* solved) {
    const int n = static_cast<int>(node_.size());
    const double scale = 1.0 / unit_;
    for (int p = 0; p < n; ++p) {
      const double* from = b.data() + 3 * static_cast<std::ptrdiff_t>(node_[static_cast<size_t>(p)]);
      float* to = r_.data() + 4 * static_cast<std::ptrdiff_t>(p);
      for (int d = 0; d < 3; ++d) to[d] = static_cast<float>(scale * from[d]);
    }
    sum_.setZero();
    p_.setZero();
    *solved = false;
    const PacketMatrix a = matrix();
    const LinkPackets links = links_.rows();
    double rz = 1.0;  // p_ is 0
    for (int iteration = 1; iteration <= most; ++iteration) {
      const double rz_new = precondition();
      if (!(rz_new > 0.0) && coarse_works_) {  // not definite after all: from here on by sweeps alone
        coarse_works_ = false;
        p_.setZero();
        rz = 1.0;
        continue;
      }
      definite_ = definite_ && rz_new >= 0.0;
      if (!(rz_new > 0.0)) return iteration;
      kernels_.direct(n, z_.data(), static_cast<float>(rz_new / rz), p_.data());
      rz = rz_new;
      double curvature = packets_.product(a, links, p_.data(), q_.data());
      if (couplings_ != nullptr) {
        const auto place = [this](int node) { return position_[static_cast<size_t>(node)]; };
        curvature += couplings_->add_beside_diagonal(place, p_, &q_);
      }
      definite_ = definite_ && curvature > 0.0;
      if (!(curvature > 0.0)) return iteration;
      const auto alpha = static_cast<float>(rz / curvature);
      const double left = kernels_.advance(n, alpha, p_.data(), q_.data(), weight_.data(), sum_.data(), r_.data());
      *solved = left <= enough;
      if (*solved) return iteration;
    }
    return most;
  }

  PacketMatrix matrix() const { return {packets(), rows_.rows(), springs_.rows(), blocks_.data(), springs_.blocks()}; }

  static double dot(const PaddedNodes& a, const PaddedNodes& b) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.cols(); ++i) sum += static_cast<double>(a.col(i).dot(b.col(i)));
    return sum;
  }

  const BlockKernels& kernels_;
  const PacketKernels& packets_;
  AggregationMultigrid coarse_;
  bool coarse_works_ = false;
  float weight_of_sweep_ = kSmoothing;
  double weight_tau_ = 0.0;  // s, of its estimate

  // In the solver's own order.
  std::vector<int> pattern_rows_, pattern_columns_, laid_out_held_;
  double stiffness_ = 0.0;            // of all links of the coarse levels, N/m
  std::vector<int> node_, position_;  // node at a position, position of a node
  std::vector<char> held_;            // by position
  RowPackets rows_;
  std::vector<int> slot_;
  std::vector<float> blocks_;   // of the matrix
  std::vector<float> inverse_;  // of the diagonal blocks, times the smoothing weight
  SpringRows springs_;
  bool laid_out_springs_ = false;
  std::vector<float> weight_;
  AxisValues row_sum_, refreshed_;  // of the matrix at hand and of the coarse levels
  PaddedNodes r_, z_, p_, q_, t_, correction_, sum_;

  const NodeCouplings* couplings_ = nullptr;
  KeptLinks links_;
  double link_tau_ = 1.0;
  std::vector<int> held_nodes_;
  double unit_ = 1.0;
  bool definite_ = true;  // as far as this solve has seen
};

}  // namespace

std::unique_ptr<MultigridSolver> make_multigrid_solver() {
  return std::make_unique<Solver>();
}

}  // namespace deformable_sim
