// Quadratic energies of distances as a term: a constant sparse matrix, the same for x, y and z.
#include <array>
#include <string>
#include <utility>

#include "deformable_sim/core/energy/quadratic_term.h"
#include "deformable_sim/core/energy/shell_terms.h"
#include "deformable_sim/core/linear/block_kernels.h"
#include "deformable_sim/core/linear/constant_links.h"

namespace deformable_sim {
namespace {

/// E = sum w/2 |x_b - x_a|^2; a weight may be negative, only the sum must not be. Damping as by the same matrix.
class QuadraticLinks : public Energy, public QuadraticTerm {
 public:
  QuadraticLinks(std::string name, std::vector<QuadraticWeight> weights, double damping, int first_node)
      : name_(std::move(name)),
        weights_(std::move(weights)),
        kernels_(block_kernels(simd_level())),
        links_(make_constant_links(weights_, damping, first_node)),
        y_(4 * links_.sum.size(), 0.0) {}

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
    const LinkRows<double> rows{links_.rows(), links_.row_start.data(), links_.place.data(), links_.stiffness.data(),
                                links_.sum.data()};
    kernels_.add_links(rows, links_.node.data(), y_.data(), f->data() + first);
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

  void add_entries(std::vector<Eigen::Triplet<double>>* stiffness,
                   std::vector<Eigen::Triplet<double>>* damping) const override {
    for (const QuadraticWeight& w : weights_) {
      add_link(world(w.a), world(w.b), w.weight, stiffness);
      if (links_.damping != 0.0) add_link(world(w.a), world(w.b), links_.damping * w.weight, damping);
    }
  }

  void add_jacobian(const State&, double dx, double dv, Jacobian, BlockMatrix* a) const override {
    const double scale = dx + dv * links_.damping;
    for (size_t k = 0; k < weights_.size(); ++k) {
      for (int slot : slots_[k]) a->block(slot).diagonal().array() -= scale * weights_[k].weight;
    }
    for (size_t i = 0; i < links_.sum.size(); ++i) {
      a->block(a->diagonal_slot(world(links_.node[i]))).diagonal().array() += scale * links_.sum[i];
    }
  }

 private:
  static void add_link(int a, int b, double weight, std::vector<Eigen::Triplet<double>>* to) {
    to->emplace_back(a, a, weight);
    to->emplace_back(b, b, weight);
    to->emplace_back(a, b, -weight);
    to->emplace_back(b, a, -weight);
  }
  int world(int node) const { return links_.first_node + node; }

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
