// Quadratic energies of distances as a term: a constant sparse matrix, the same for x, y and z.
#include <algorithm>
#include <string>
#include <utility>

#include "deformable_sim/core/energy/constant_links.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/linear/block_kernels.h"

namespace deformable_sim {
namespace {

/// E = sum w/2 |x_b - x_a|^2; a weight may be negative, only the sum must not be. Damping as by the same matrix.
class QuadraticLinks : public Energy {
 public:
  QuadraticLinks(std::string name, std::vector<QuadraticWeight> weights, double damping, int first_node)
      : name_(std::move(name)), weights_(std::move(weights)), kernels_(block_kernels(simd_level())) {
    links_.damping = damping;
    links_.first_node = first_node;
    fill_rows();
  }

  std::string name() const override { return name_; }
  int element_count() const override { return static_cast<int>(weights_.size()); }
  const ConstantLinks* constant_links() const override { return &links_; }

  double value(const State& s) const override {
    double sum = 0.0;
    for (const QuadraticWeight& w : weights_) {
      sum += 0.5 * w.weight * (s.x.col(world(w.b)) - s.x.col(world(w.a))).squaredNorm();
    }
    return sum;
  }

  void add_force(const State& s, Nodes* f) const override {
    const size_t first = 3 * static_cast<size_t>(links_.first_node);
    const double* x = s.x.data() + first;
    const double* v = s.v.data() + first;
    for (int i = 0; i < links_.rows(); ++i) {
      for (int d = 0; d < 3; ++d) y_[static_cast<size_t>(4 * i + d)] = x[3 * i + d] + links_.damping * v[3 * i + d];
    }
    kernels_.add_links(
        {links_.rows(), links_.row_start.data(), links_.column.data(), links_.stiffness.data(), links_.sum.data()},
        y_.data(), f->data() + first);
  }

  void add_pattern(std::vector<std::array<int, 2>>* pairs) const override {
    for (const QuadraticWeight& w : weights_) pairs->push_back({world(w.a), world(w.b)});
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.clear();
    for (const QuadraticWeight& w : weights_) {
      const int a = world(w.a), b = world(w.b);
      slots_.push_back({matrix.slot(a, b), matrix.slot(b, a)});
    }
  }

  void add_jacobian(const State&, double dx, double dv, Jacobian, BlockMatrix* a) const override {
    const double scale = dx + dv * links_.damping;
    for (size_t k = 0; k < weights_.size(); ++k) {
      for (int slot : slots_[k]) a->block(slot).diagonal().array() -= scale * weights_[k].weight;
    }
    for (int i = 0; i < links_.rows(); ++i) {
      a->block(a->diagonal_slot(world(i))).diagonal().array() += scale * links_.sum[static_cast<size_t>(i)];
    }
  }

 private:
  int world(int node) const { return links_.first_node + node; }

  void fill_rows() {
    int rows = 0;
    for (const QuadraticWeight& w : weights_) rows = std::max({rows, w.a + 1, w.b + 1});
    const auto n = static_cast<size_t>(rows);
    links_.row_start.assign(n + 1, 0);
    for (const QuadraticWeight& w : weights_) {
      ++links_.row_start[static_cast<size_t>(w.a) + 1];
      ++links_.row_start[static_cast<size_t>(w.b) + 1];
    }
    for (size_t i = 0; i < n; ++i) links_.row_start[i + 1] += links_.row_start[i];
    std::vector<int> next(links_.row_start.begin(), links_.row_start.end() - 1);
    links_.column.resize(2 * weights_.size());
    links_.stiffness.resize(2 * weights_.size());
    links_.sum.assign(n, 0.0);
    const auto put = [&](int i, int j, double weight) {
      const auto at = static_cast<size_t>(next[static_cast<size_t>(i)]++);
      links_.column[at] = j;
      links_.stiffness[at] = weight;
      links_.sum[static_cast<size_t>(i)] += weight;
    };
    for (const QuadraticWeight& w : weights_) {
      put(w.a, w.b, w.weight);
      put(w.b, w.a, w.weight);
    }
    y_.assign(4 * n, 0.0);
  }

  std::string name_;
  std::vector<QuadraticWeight> weights_;
  const BlockKernels& kernels_;
  ConstantLinks links_;
  std::vector<std::array<int, 2>> slots_;  // parallel to weights_, once bound
  mutable std::vector<double> y_;          // of the evaluation in progress: a term is used by one thread at a time
};

}  // namespace

std::unique_ptr<Energy> make_quadratic_links(const std::string& name, const std::vector<QuadraticWeight>& weights,
                                             double damping, int first_node) {
  return std::make_unique<QuadraticLinks>(name, weights, damping, first_node);
}

}  // namespace deformable_sim
