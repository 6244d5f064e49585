#include "deformable_sim/core/linear/multigrid_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "deformable_sim/core/linear/aggregation_multigrid.h"
#include "deformable_sim/core/linear/packet_kernels.h"
#include "deformable_sim/core/linear/row_order.h"

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
// Links below this share of the geometric mean of both rows' sums are left out: Newton's matrix need not be exact, and
// of a plate on a crooked mesh they are half of all.
constexpr double kLeastLink = 0.01;
constexpr double kOtherStiffness = 1.5;  // a Laplacian that has changed by more is made anew

using Neighbours = std::vector<std::vector<int>>;

/// Nodes breadth first from a node of least degree, so that neighbours lie near each other in memory [Cuthill 1969].
std::vector<int> breadth_first(const Neighbours& neighbours) {
  const auto degree = [&](int i) { return neighbours[static_cast<size_t>(i)].size(); };
  std::vector<int> starts(neighbours.size()), order, next;
  for (size_t i = 0; i < starts.size(); ++i) starts[i] = static_cast<int>(i);
  std::stable_sort(starts.begin(), starts.end(), [&](int i, int j) { return degree(i) < degree(j); });
  std::vector<char> seen(starts.size(), 0);
  for (int start : starts) {
    if (seen[static_cast<size_t>(start)] != 0) continue;
    seen[static_cast<size_t>(start)] = 1;
    order.push_back(start);
    for (size_t k = order.size() - 1; k < order.size(); ++k) {
      next.clear();
      for (int j : neighbours[static_cast<size_t>(order[k])]) {
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

bool same_springs(const std::vector<SpringElement>& one, const std::vector<SpringElement>& other) {
  return std::equal(
      one.begin(), one.end(), other.begin(), other.end(), [](const SpringElement& s, const SpringElement& t) {
        return s.a == t.a && s.b == t.b && s.length == t.length && s.stiffness == t.stiffness && s.damping == t.damping;
      });
}

class Solver : public MultigridSolver {
 public:
  Solver() : kernels_(block_kernels(simd_level())), packets_(packet_kernels(simd_level())), coarse_(kernels_) {}

  void set_links(const std::vector<const ConstantLinks*>& links, double tau, const std::vector<int>& held) override {
    links_ = links;
    link_tau_ = tau;
    held_nodes_ = held;
  }

  void set_springs(const std::vector<SpringElement>& springs) override {
    if (same_springs(springs, springs_)) return;
    springs_ = springs;
    laid_out_springs_ = false;
  }

  void place_springs(const Nodes& x, double dx, double dv, Transverse transverse) override {
    x_ = &x;
    dx_ = dx;
    dv_ = dv;
    transverse_ = transverse == Transverse::kProjected ? 1.0 : 0.0;
  }

  void forget() override { stiffness_ = weight_tau_ = 0.0; }

  void prepare(const BlockMatrix& a) override {
    const bool same = laid_out_springs_ && a.row_start() == pattern_rows_ && a.column() == pattern_columns_ &&
                      held_nodes_ == laid_out_held_;
    if (!same) {
      lay_out(a);
      lay_out_links(a.rows());
    }
    scale_links();
    // A shorter step makes lambda_max smaller.
    if (!same || link_tau_ > weight_tau_) set_weight(a);
    const double stiffness = total_weight(a);
    if (same && stiffness < kOtherStiffness * stiffness_ && stiffness_ < kOtherStiffness * stiffness) return;
    stiffness_ = stiffness;
    coarse_.prepare(laplacian_of(a));
    refreshed_.setZero();
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
    report.iterations = iterate(b, goal / norm, tolerance.iterations, &report.solved);
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
    size_links(a.rows());
    sort_by_length(neighbours);
    position_.resize(n);
    for (size_t p = 0; p < n; ++p) position_[static_cast<size_t>(node_[p])] = static_cast<int>(p);
    held_.assign(n, 0);
    for (int node : held_nodes_) held_[static_cast<size_t>(position_[static_cast<size_t>(node)])] = 1;
    pack_blocks(a);
    pack_springs();
    const auto padded = static_cast<Eigen::Index>(packets()) * packets_.width;
    inverse_.assign(static_cast<size_t>(6 * padded), 0.0f);
    weight_.resize(n);
    for (AxisValues* values : {&row_sum_, &refreshed_}) values->setZero(4, padded);
    for (PaddedNodes* m : {&r_, &z_, &p_, &q_, &t_, &correction_, &sum_, &points_}) m->setZero(4, padded);
  }

  int packets() const { return (static_cast<int>(node_.size()) + packets_.width - 1) / packets_.width; }
  /// Where numbers by lanes of a position lie.
  size_t lane_place(int position) const {
    const int offset = position % packets_.width;
    return static_cast<size_t>(position - offset + packet_lane(offset, packets_.width));
  }
  template <class Length>
  static size_t longest_of(int first, int last, const Length& length) {
    size_t longest = 0;
    for (int p = first; p < last; ++p) longest = std::max(longest, length(p));
    return longest;
  }

  /// Rows of blocks in packets, the diagonal first.
  void pack_blocks(const BlockMatrix& a) {
    const int width = packets_.width, n = a.rows();
    start_.assign(1, 0);
    place_.clear();
    slot_.clear();
    const auto length = [&](int p) {
      const auto i = static_cast<size_t>(node_[static_cast<size_t>(p)]);
      return static_cast<size_t>(a.row_start()[i + 1] - a.row_start()[i]);
    };
    std::vector<std::array<int, 2>> row;
    for (int first = 0; first < packets() * width; first += width) {
      const auto before = place_.size();
      const size_t longest = longest_of(first, std::min(first + width, n), length);
      start_.push_back(start_.back() + static_cast<int>(longest));
      place_.resize(before + longest * static_cast<size_t>(width));
      slot_.resize(place_.size(), -1);
      for (int p = first; p < first + width; ++p) {
        const auto lane = before + lane_place(p) - static_cast<size_t>(first);
        for (size_t k = 0; k < longest; ++k) place_[lane + k * static_cast<size_t>(width)] = 4 * p;
        if (p >= n) continue;
        row.clear();
        const int i = node_[static_cast<size_t>(p)];
        for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
          const int column = a.column()[static_cast<size_t>(k)];
          row.push_back({column == i ? -1 : position_[static_cast<size_t>(column)], k});
        }
        std::sort(row.begin(), row.end());
        for (size_t k = 0; k < row.size(); ++k) {
          const size_t at = lane + k * static_cast<size_t>(width);
          if (row[k][0] >= 0) place_[at] = 4 * row[k][0];
          slot_[at] = row[k][1];
        }
      }
    }
    blocks_.assign(9 * place_.size(), 0.0f);
  }

  /// Rows of springs in packets; none in rows that are held.
  void pack_springs() {
    const int width = packets_.width, n = static_cast<int>(node_.size());
    struct Entry {
      int column;
      const SpringElement* spring;
    };
    std::vector<std::vector<Entry>> rows(node_.size());
    for (const SpringElement& s : springs_) {
      const int a = position_[static_cast<size_t>(s.a)], b = position_[static_cast<size_t>(s.b)];
      if (!is_held(a)) rows[static_cast<size_t>(a)].push_back({b, &s});
      if (!is_held(b)) rows[static_cast<size_t>(b)].push_back({a, &s});
    }
    spring_start_.assign(springs_.empty() ? 0 : 1, 0);
    spring_place_.clear();
    std::vector<float>* const numbers[] = {&spring_stiffness_, &spring_damping_, &spring_length_, &spring_held_};
    for (std::vector<float>* values : numbers) values->clear();
    for (int first = 0; first < packets() * width && !springs_.empty(); first += width) {
      const auto before = spring_place_.size();
      const size_t longest =
          longest_of(first, std::min(first + width, n), [&](int p) { return rows[static_cast<size_t>(p)].size(); });
      spring_start_.push_back(spring_start_.back() + static_cast<int>(longest));
      spring_place_.resize(before + longest * static_cast<size_t>(width));
      for (std::vector<float>* values : numbers) values->resize(spring_place_.size(), 0.0f);
      for (int p = first; p < first + width; ++p) {
        const auto lane = before + lane_place(p) - static_cast<size_t>(first);
        for (size_t k = 0; k < longest; ++k) {
          const size_t at = lane + k * static_cast<size_t>(width);
          spring_place_[at] = 4 * p;
          if (p >= n || k >= rows[static_cast<size_t>(p)].size()) continue;
          const Entry& entry = rows[static_cast<size_t>(p)][k];
          spring_place_[at] = 4 * entry.column;
          spring_stiffness_[at] = static_cast<float>(entry.spring->stiffness);
          spring_damping_[at] = static_cast<float>(entry.spring->damping);
          spring_length_[at] = static_cast<float>(entry.spring->length);
          spring_held_[at] = is_held(entry.column) ? 1.0f : 0.0f;
        }
      }
    }
    spring_blocks_.assign(4 * spring_place_.size(), 0.0f);
  }

  /// Frobenius norm of a spring's block.
  double norm_of(const SpringElement& s) const {
    const double length = (x_->col(s.b) - x_->col(s.a)).norm();
    const double across = transverse_ * std::max(0.0, dx_ * s.stiffness * (1.0 - s.length / std::max(length, 1e-12)));
    const double along = dx_ * s.stiffness + dv_ * s.damping;
    return std::sqrt(along * along + 2.0 * across * across);
  }

  void size_links(int rows) {
    link_size_.assign(static_cast<size_t>(rows), 0.0);
    for (const ConstantLinks* links : links_) {
      for (size_t row = 0; row < links->sum.size(); ++row) {
        link_size_[static_cast<size_t>(links->first_node + links->node[row])] = std::sqrt(std::abs(links->sum[row]));
      }
    }
  }

  Neighbours neighbours_of(const BlockMatrix& a) const {
    Neighbours neighbours(static_cast<size_t>(a.rows()));
    for (size_t i = 0; i < neighbours.size(); ++i) {
      neighbours[i].assign(a.column().begin() + a.row_start()[i], a.column().begin() + a.row_start()[i + 1]);
    }
    for (const SpringElement& s : springs_) {
      neighbours[static_cast<size_t>(s.a)].push_back(s.b);
      neighbours[static_cast<size_t>(s.b)].push_back(s.a);
    }
    return neighbours;
  }

  void sort_by_length(const Neighbours& neighbours) {
    std::vector<int> kept(node_.size(), 0), length(node_.size());
    for (const ConstantLinks* links : links_) {
      for (size_t row = 0; row < links->sum.size(); ++row) {
        int& count = kept[static_cast<size_t>(links->first_node + links->node[row])];
        for_each_kept(*links, row, [&](int, double) { ++count; });
      }
    }
    for (size_t i = 0; i < node_.size(); ++i) {
      length[i] = 1024 * static_cast<int>(neighbours[i].size()) + kept[i];
    }
    sort_in_windows([&](int i) { return length[static_cast<size_t>(i)]; }, &node_);
  }

  /// visit(node, stiffness) for the links of a row that count.
  void for_each_kept(const ConstantLinks& links, size_t row, const std::function<void(int, double)>& visit) const {
    const double least = kLeastLink * std::sqrt(std::abs(links.sum[row]));
    for (int e = links.row_start[row]; e < links.row_start[row + 1]; ++e) {
      const auto k = static_cast<size_t>(e);
      const int j = links.first_node + static_cast<int>(links.place[k] / 4);
      const double other = link_size_[static_cast<size_t>(j)];
      if (links.stiffness[k] != 0.0 && std::abs(links.stiffness[k]) >= least * other) visit(j, links.stiffness[k]);
    }
  }

  /// All links together. Nodes that are held take part in neither row nor column.
  void lay_out_links(int rows) {
    link_start_.clear();
    link_place_.clear();
    link_stiffness_.clear();
    link_damping_.clear();
    link_sum_.assign(static_cast<size_t>(packets() * packets_.width), 1.0f);  // rows that do not exist keep it
    held_links_.assign(static_cast<size_t>(rows), {0.0f, 0.0f});
    if (links_.empty()) return;
    struct Link {
      int column;
      float stiffness, damping;
    };
    std::vector<std::vector<Link>> by_row(static_cast<size_t>(rows));
    for (const ConstantLinks* links : links_) {
      for (size_t row = 0; row < links->sum.size(); ++row) {
        const auto p = static_cast<size_t>(position_[static_cast<size_t>(links->first_node + links->node[row])]);
        if (held_[p] != 0) continue;
        for_each_kept(*links, row, [&](int j, double stiffness) {
          const int other = position_[static_cast<size_t>(j)];
          const auto k = static_cast<float>(stiffness), c = static_cast<float>(links->damping * stiffness);
          if (is_held(other)) {
            held_links_[p][0] += k;
            held_links_[p][1] += c;
          } else {
            by_row[p].push_back({other, k, c});
          }
        });
      }
    }
    link_start_.assign(1, 0);
    const int width = packets_.width;
    for (int first = 0; first < packets() * width; first += width) {
      const auto before = link_place_.size();
      const size_t longest = longest_of(first, std::min(first + width, rows),
                                        [&](int p) { return by_row[static_cast<size_t>(p)].size(); });
      link_start_.push_back(link_start_.back() + static_cast<int>(longest));
      link_place_.resize(before + longest * static_cast<size_t>(width));
      link_stiffness_.resize(link_place_.size(), 0.0f);
      link_damping_.resize(link_place_.size(), 0.0f);
      for (int p = first; p < first + width; ++p) {
        const auto lane = before + lane_place(p) - static_cast<size_t>(first);
        for (size_t k = 0; k < longest; ++k) {
          const size_t at = lane + k * static_cast<size_t>(width);
          link_place_[at] = 4 * p;
          if (p >= rows || k >= by_row[static_cast<size_t>(p)].size()) continue;
          const Link& link = by_row[static_cast<size_t>(p)][k];
          link_place_[at] = 4 * link.column;
          link_stiffness_[at] = link.stiffness;
          link_damping_[at] = link.damping;
        }
      }
    }
    link_value_.resize(link_place_.size());
  }

  /// k + c / tau, and the sums over rows.
  void scale_links() {
    const auto rate = static_cast<float>(1.0 / link_tau_);
    for (size_t k = 0; k < link_value_.size(); ++k) link_value_[k] = link_stiffness_[k] + rate * link_damping_[k];
    const auto width = static_cast<size_t>(packets_.width);
    for (size_t p = 0; p < held_links_.size(); ++p) {
      link_sum_[lane_place(static_cast<int>(p))] = held_links_[p][0] + rate * held_links_[p][1];
    }
    for (size_t packet = 0; packet + 1 < link_start_.size(); ++packet) {
      for (auto k = static_cast<size_t>(link_start_[packet]); k < static_cast<size_t>(link_start_[packet + 1]); ++k) {
        for (size_t lane = 0; lane < width; ++lane) link_sum_[packet * width + lane] += link_value_[k * width + lane];
      }
    }
  }

  double total_weight(const BlockMatrix& a) const {
    double sum = 0.0;
    for (int k = 0; k < a.block_count(); ++k) sum += a.block(k).norm();
    for (int i = 0; i < a.rows(); ++i) sum -= a.block(a.diagonal_slot(i)).norm();
    for (const SpringElement& s : springs_) sum += 2.0 * norm_of(s);
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
    for (const SpringElement& s : springs_) {
      const int p = position_[static_cast<size_t>(s.a)], q = position_[static_cast<size_t>(s.b)];
      if (is_held(p) || is_held(q)) continue;
      const double weight = kWeight * norm_of(s);
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
      packets_.residue(rows(), r_.data(), z_.data(), t_.data());
      packets_.sweep(packets(), inverse_.data(), t_.data(), z_.data());
      largest = z_.norm();
      z_ /= largest;
    }
    weight_of_sweep_ = std::min(kSmoothing, kBelowLimit / largest);
  }

  void copy(const BlockMatrix& a) {
    if (!springs_.empty()) {
      const Vec3 origin = x_->col(0);
      for (size_t p = 0; p < node_.size(); ++p) {
        points_.col(static_cast<Eigen::Index>(p)).head<3>() = (x_->col(node_[p]) - origin).cast<float>();
      }
    }
    const SpringSource springs{
        spring_stiffness_.data(), spring_damping_.data(),  spring_length_.data(),   spring_held_.data(),
        points_.data(),           static_cast<float>(dx_), static_cast<float>(dv_), static_cast<float>(transverse_)};
    packets_.load(rows(), {slot_.data(), a.block(0).data()}, springs, link_sum_.data(), weight_of_sweep_,
                  blocks_.data(), spring_blocks_.data(), inverse_.data(), row_sum_.data());
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
    const PacketMatrix a = rows();
    packets_.residue(a, r_.data(), z_.data(), t_.data());
    coarse_.correct(t_, &correction_);
    return packets_.correct(a, inverse_.data(), t_.data(), correction_.data(), r_.data(), z_.data());
  }

  /// From zero: sum_ * unit_ is the solution. Returns the iterations spent.
  int iterate(const Nodes& b, double reduction, int most, bool* solved) {
    const int n = static_cast<int>(node_.size());
    unit_ = b.cwiseAbs().maxCoeff();  // keeps single precision far from its ends
    double squares = 0.0;
    for (size_t p = 0; p < node_.size(); ++p) {
      const auto column = static_cast<Eigen::Index>(p);
      r_.col(column).head<3>() = (b.col(node_[p]) / unit_).cast<float>();
      squares += static_cast<double>((weight_[p] * r_.col(column)).squaredNorm());
    }
    sum_.setZero();
    p_.setZero();
    *solved = false;
    const PacketMatrix a = rows();
    const LinkPackets links{
        {link_start_.empty() ? nullptr : link_start_.data(), link_place_.data()}, link_value_.data(), link_sum_.data()};
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
      const double curvature = packets_.product(a, links, p_.data(), q_.data());
      definite_ = definite_ && curvature > 0.0;
      if (!(curvature > 0.0)) return iteration;
      const auto alpha = static_cast<float>(rz / curvature);
      const double left = kernels_.advance(n, alpha, p_.data(), q_.data(), weight_.data(), sum_.data(), r_.data());
      *solved = left <= reduction * reduction * squares;
      if (*solved) return iteration;
    }
    return most;
  }

  PacketMatrix rows() const {
    return {packets(),
            {start_.data(), place_.data()},
            {spring_start_.empty() ? nullptr : spring_start_.data(), spring_place_.data()},
            blocks_.data(),
            spring_blocks_.data()};
  }

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
  double stiffness_ = 0.0;                 // of all links of the coarse levels, N/m
  std::vector<int> node_, position_;       // node at a position, position of a node
  std::vector<char> held_;                 // by position
  std::vector<int> start_, place_, slot_;  // see PacketMatrix
  std::vector<float> blocks_;              // of the matrix
  std::vector<float> inverse_;             // of the diagonal blocks, times the smoothing weight
  std::vector<float> weight_;
  AxisValues row_sum_, refreshed_;  // of the matrix at hand and of the coarse levels
  PaddedNodes r_, z_, p_, q_, t_, correction_, sum_;

  // Springs.
  std::vector<SpringElement> springs_;
  bool laid_out_springs_ = false;
  const Nodes* x_ = nullptr;
  double dx_ = 0.0, dv_ = 0.0, transverse_ = 1.0;
  std::vector<int> spring_start_, spring_place_;
  std::vector<float> spring_stiffness_, spring_damping_, spring_length_, spring_held_, spring_blocks_;
  PaddedNodes points_;  // less the first node's position

  // Constant links, all together.
  std::vector<const ConstantLinks*> links_;
  double link_tau_ = 1.0;
  std::vector<int> held_nodes_;
  std::vector<double> link_size_;  // by node: square root of the row's sum
  std::vector<int> link_start_, link_place_;
  std::vector<float> link_stiffness_, link_damping_;  // k in N/m, c in N s/m
  std::vector<std::array<float, 2>> held_links_;      // k and c to held nodes, by row
  std::vector<float> link_value_, link_sum_;          // k + c / tau; the sum by lanes

  double unit_ = 1.0;
  bool definite_ = true;  // as far as this solve has seen
};

}  // namespace

std::unique_ptr<MultigridSolver> make_multigrid_solver() {
  return std::make_unique<Solver>();
}

}  // namespace deformable_sim
