// Narrow parts of a matrix exactly, everything else by conjugate gradients.
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "band_factor.h"
#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {
namespace {

/// The rows that are left to conjugate gradients, as a matrix of their own.
struct Others {
  std::vector<int> nodes, slots;  // in the whole matrix
  BlockMatrix matrix;
  Nodes b, x;
  Eigen::VectorXd weight;

  void choose(std::vector<int> chosen, const BlockMatrix& a) {
    nodes = std::move(chosen);
    slots.clear();
    std::vector<int> local(static_cast<size_t>(a.rows()), -1);
    for (size_t k = 0; k < nodes.size(); ++k) local[static_cast<size_t>(nodes[k])] = static_cast<int>(k);
    std::vector<std::array<int, 2>> pairs;
    for (int i : nodes) {
      for (int k = a.row_start()[static_cast<size_t>(i)]; k < a.row_start()[static_cast<size_t>(i) + 1]; ++k) {
        slots.push_back(k);
        pairs.push_back(
            {local[static_cast<size_t>(i)], local[static_cast<size_t>(a.column()[static_cast<size_t>(k)])]});
      }
    }
    const auto count = static_cast<Eigen::Index>(nodes.size());
    matrix = BlockMatrix(static_cast<int>(count), pairs);
    b.resize(3, count);
    x.resize(3, count);
    weight.resize(count);
  }

  /// Nodes keep their order, so that blocks do.
  void copy_blocks(const BlockMatrix& a) {
    for (size_t k = 0; k < slots.size(); ++k) matrix.block(static_cast<int>(k)) = a.block(slots[k]);
  }
};

class BandedSolver : public LinearSolver {
 public:
  void prepare(const BlockMatrix& a) override {
    if (a.row_start() != pattern_rows_ || a.column() != pattern_columns_) split(a);
    if (bands_.empty()) {
      iterative_->prepare(a);
    } else if (iterative_ != nullptr) {
      others_.copy_blocks(a);
      iterative_->prepare(others_.matrix);
    }
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                     const LinearTolerance& tolerance, Nodes* x) override {
    if (bands_.empty()) return iterative_->solve(a, b, weight, tolerance, x);
    LinearReport report;
    if (iterative_ != nullptr) report = solve_others(a, b, weight, tolerance, x);
    for (const auto& band : bands_) {
      const LinearReport part = band->solve(a, b, x);
      report.solved = report.solved && part.solved;
      report.definite = report.definite && part.definite;
    }
    report.kept = iterative_ == nullptr;
    return report;
  }

  bool solve_again(const Nodes& b, Nodes* x) override {
    if (bands_.empty() || iterative_ != nullptr) return false;
    for (const auto& band : bands_) band->solve_again(b, x);
    return true;
  }

 private:
  void split(const BlockMatrix& a) {
    pattern_rows_ = a.row_start();
    pattern_columns_ = a.column();
    BandParts found = band_parts(a, kWidestBand);
    bands_.clear();
    for (const BandPart& part : found.parts) bands_.push_back(make_band_factor(a, part));
    iterative_.reset();
    if (bands_.empty() || !found.others.empty()) iterative_ = make_conjugate_gradient_solver();
    others_ = Others();
    if (!bands_.empty()) others_.choose(std::move(found.others), a);
  }

  LinearReport solve_others(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                            const LinearTolerance& tolerance, Nodes* x) {
    others_.copy_blocks(a);
    for (size_t k = 0; k < others_.nodes.size(); ++k) {
      const int node = others_.nodes[k];
      others_.b.col(static_cast<Eigen::Index>(k)) = b.col(node);
      others_.x.col(static_cast<Eigen::Index>(k)) = x->col(node);
      others_.weight[static_cast<Eigen::Index>(k)] = weight[node];
    }
    const LinearReport report = iterative_->solve(others_.matrix, others_.b, others_.weight, tolerance, &others_.x);
    for (size_t k = 0; k < others_.nodes.size(); ++k)
      x->col(others_.nodes[k]) = others_.x.col(static_cast<Eigen::Index>(k));
    return report;
  }

  std::vector<int> pattern_rows_, pattern_columns_;
  std::vector<std::unique_ptr<BandFactor>> bands_;
  Others others_;
  std::unique_ptr<LinearSolver> iterative_;  // null: there are no others
};

}  // namespace

std::unique_ptr<LinearSolver> make_banded_solver() {
  return std::make_unique<BandedSolver>();
}

}  // namespace deformable_sim
