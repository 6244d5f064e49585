// Sparse direct solution of implicit steps.
#include <Eigen/SparseCholesky>

#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {
namespace {

class DirectSolver : public LinearSolver {
 public:
  void prepare(const BlockMatrix& a) override {
    matrix_ = a.to_sparse();
    factor_.analyzePattern(matrix_);
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd&, const LinearTolerance&,
                     Nodes* x) override {
    copy_values(a);
    factor_.factorize(matrix_);
    LinearReport report;
    report.solved = factor_.info() == Eigen::Success;
    report.definite = report.solved && factor_.vectorD().minCoeff() > 0.0;
    x->resize(3, b.cols());
    if (!report.solved) {
      x->setZero();
      return report;
    }
    Eigen::Map<Eigen::VectorXd>(x->data(), x->size()) =
        factor_.solve(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
    return report;
  }

 private:
  /// The pattern is symmetric: column j of the scalar matrix holds the blocks of block row j, transposed.
  void copy_values(const BlockMatrix& a) {
    double* value = matrix_.valuePtr();
    for (int j = 0; j < a.rows(); ++j) {
      const int first = a.row_start()[static_cast<size_t>(j)], last = a.row_start()[static_cast<size_t>(j) + 1];
      for (int column = 0; column < 3; ++column) {
        for (int k = first; k < last; ++k) {
          for (int row = 0; row < 3; ++row) *value++ = a.block(k)(column, row);
        }
      }
    }
  }

  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace

std::unique_ptr<LinearSolver> make_direct_solver() {
  return std::make_unique<DirectSolver>();
}

}  // namespace deformable_sim
