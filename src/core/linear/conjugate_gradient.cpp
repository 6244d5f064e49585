// Preconditioned conjugate gradients in single precision, refined in double precision.
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/LU>

#include "deformable_sim/core/linear/linear_solver.h"
#include "deformable_sim/core/linear/node_couplings.h"
#include "deformable_sim/core/linear/scalar_factor.h"

namespace deformable_sim {
namespace {

constexpr double kSmoothing = 0.65;        // below 2 / 3, so that three-node terms keep the preconditioner definite
constexpr double kSinglePrecision = 1e-4;  // the reduction asked of one pass in single precision

using Padded3 = Eigen::Matrix<float, 4, 3>;  // a 3x3 block, one SIMD register a column

Padded3 padded(const Mat3& block) {
  Padded3 result = Padded3::Zero();
  result.topRows<3>() = block.cast<float>();
  return result;
}

inline Eigen::Vector4f times(const Padded3& block, const float* x) {
  return block.col(0) * x[0] + block.col(1) * x[1] + block.col(2) * x[2];
}

class ConjugateGradient : public LinearSolver {
 public:
  void prepare(const BlockMatrix& a) override {
    factor_.prepare(a);
    const auto n = static_cast<size_t>(a.rows());
    blocks_.resize(static_cast<size_t>(a.block_count()));
    inverse_.resize(n);
    for (PaddedNodes* m : {&r_, &z_, &p_, &ap_, &t_, &coarse_, &work_, &sum_}) m->setZero(4, a.rows());
    residual_.setZero(3, a.rows());
    product_.setZero(3, a.rows());
  }

  LinearReport solve(const BlockMatrix& a, const Nodes& b, const Eigen::VectorXd& weight,
                     const LinearTolerance& tolerance, Nodes* x) override {
    load(a);
    LinearReport report;
    definite_ = true;
    const double start = rms(b, weight);
    const double goal = std::max(tolerance.absolute, tolerance.relative * start);
    residual_ = b;
    if (!x->isZero(0.0)) {
      a.multiply(*x, &product_);
      if (couplings_ != nullptr) couplings_->add_beside_diagonal([](int node) { return node; }, *x, &product_);
      residual_ -= product_;
    }
    double norm = rms(residual_, weight);
    while (norm > goal && report.iterations < tolerance.iterations) {
      const double reduction = std::max(goal / norm * 0.9, kSinglePrecision);
      report.iterations += pass(a, weight, reduction, tolerance.iterations - report.iterations);
      *x += sum_.topRows<3>().cast<double>() * unit_;
      report.definite = definite_;
      if (reduction > kSinglePrecision && report.iterations < tolerance.iterations) return report;
      a.multiply(*x, &product_);
      if (couplings_ != nullptr) couplings_->add_beside_diagonal([](int node) { return node; }, *x, &product_);
      residual_ = b - product_;
      const double last = norm;
      norm = rms(residual_, weight);
      if (!(norm < 0.5 * last)) break;  // round-off, or a matrix that is not definite
    }
    report.solved = norm <= goal;
    return report;
  }

  bool take(const NodeCouplings* couplings) override {
    couplings_ = couplings;
    return true;
  }

 private:
  static double rms(const Nodes& r, const Eigen::VectorXd& weight) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < r.cols(); ++i) sum += r.col(i).squaredNorm() * weight[i] * weight[i];
    return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(1, r.cols())));
  }

  double rms(const PaddedNodes& r, const Eigen::VectorXd& weight) const {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < r.cols(); ++i) {
      const double w = weight[i];
      sum += static_cast<double>(r.col(i).squaredNorm()) * w * w;
    }
    return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(1, r.cols())));
  }

  /// Single precision copy, inverse diagonal blocks, and a new scalar factor if contacts have changed.
  void load(const BlockMatrix& a) {
    for (int k = 0; k < a.block_count(); ++k) blocks_[static_cast<size_t>(k)] = padded(a.block(k));
    for (int i = 0; i < a.rows(); ++i) {
      inverse_[static_cast<size_t>(i)] = padded(kSmoothing * a.block(a.diagonal_slot(i)).inverse());
    }
    factor_.refresh(a);
  }

  void multiply(const BlockMatrix& a, const PaddedNodes& x, PaddedNodes* y) const {
    const int* column = a.column().data();
    for (int i = 0; i < a.rows(); ++i) {
      Eigen::Vector4f sum = Eigen::Vector4f::Zero(), other = sum;  // two chains hide the latency of the sum
      int k = a.row_start()[static_cast<size_t>(i)];
      const int last = a.row_start()[static_cast<size_t>(i) + 1];
      for (; last - k > 1; k += 2) {
        sum += times(blocks_[static_cast<size_t>(k)], x.data() + 4 * column[k]);
        other += times(blocks_[static_cast<size_t>(k) + 1], x.data() + 4 * column[k + 1]);
      }
      if (k != last) sum += times(blocks_[static_cast<size_t>(k)], x.data() + 4 * column[k]);
      y->col(i) = sum + other;
    }
  }

  /// z = M^-1 r: block-Jacobi, scalar solve, block-Jacobi, each on what the one before has left.
  void precondition(const BlockMatrix& a) {
    const Eigen::Index n = r_.cols();
    for (Eigen::Index i = 0; i < n; ++i) z_.col(i) = times(inverse_[static_cast<size_t>(i)], r_.data() + 4 * i);
    multiply(a, z_, &ap_);
    t_ = r_ - ap_;
    coarse_ = t_;
    factor_.solve(&coarse_, &work_);
    z_ += coarse_;
    multiply(a, coarse_, &ap_);
    t_ -= ap_;
    for (Eigen::Index i = 0; i < n; ++i) z_.col(i) += times(inverse_[static_cast<size_t>(i)], t_.data() + 4 * i);
  }

  /// One pass from zero on residual_: sum_ * unit_ is the correction. Returns the iterations spent.
  int pass(const BlockMatrix& a, const Eigen::VectorXd& weight, double reduction, int most) {
    unit_ = residual_.cwiseAbs().maxCoeff();  // keeps single precision far from its ends
    r_.topRows<3>() = (residual_ / unit_).cast<float>();
    sum_.setZero();
    const double goal = reduction * rms(r_, weight);
    double rz = 0.0;
    for (int iteration = 1; iteration <= most; ++iteration) {
      precondition(a);
      const double rz_new = dot(r_, z_);
      definite_ = definite_ && rz_new >= 0.0;
      if (!(rz_new > 0.0)) return iteration;
      if (iteration == 1) {
        p_ = z_;
      } else {
        p_ = z_ + static_cast<float>(rz_new / rz) * p_;
      }
      rz = rz_new;
      multiply(a, p_, &ap_);
      if (couplings_ != nullptr) couplings_->add_beside_diagonal([](int node) { return node; }, p_, &ap_);
      const double curvature = dot(p_, ap_);
      definite_ = definite_ && curvature > 0.0;
      if (!(curvature > 0.0)) return iteration;
      const auto alpha = static_cast<float>(rz / curvature);
      sum_ += alpha * p_;
      r_ -= alpha * ap_;
      if (rms(r_, weight) <= goal) return iteration;
    }
    return most;
  }

  static double dot(const PaddedNodes& a, const PaddedNodes& b) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < a.cols(); ++i) sum += static_cast<double>(a.col(i).dot(b.col(i)));
    return sum;
  }

  ScalarFactor factor_;
  const NodeCouplings* couplings_ = nullptr;
  std::vector<Padded3> blocks_;   // of the matrix, by slot
  std::vector<Padded3> inverse_;  // of the diagonal blocks, times the smoothing weight
  PaddedNodes r_, z_, p_, ap_, t_, coarse_, work_, sum_;
  Nodes residual_, product_;
  double unit_ = 1.0;
  bool definite_ = true;  // as far as this solve has seen
};

}  // namespace

std::unique_ptr<LinearSolver> make_conjugate_gradient_solver() {
  return std::make_unique<ConjugateGradient>();
}

}  // namespace deformable_sim
