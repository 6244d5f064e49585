#include "deformable_sim/core/linear/node_couplings.h"

#include <algorithm>
#include <cmath>

namespace deformable_sim {
namespace {

double norm(const Nodes& r, const Eigen::VectorXd& weight) {
  double sum = 0.0, count = 0.0;
  for (Eigen::Index i = 0; i < r.cols(); ++i) {
    if (weight[i] == 0.0) continue;
    sum += weight[i] * weight[i] * r.col(i).squaredNorm();
    count += 1.0;
  }
  return std::sqrt(sum / std::max(1.0, count));
}

double dot(const Nodes& a, const Nodes& b) {
  return a.cwiseProduct(b).sum();
}

}  // namespace

void NodeCouplings::solve(const Nodes& b, const Eigen::VectorXd& weight, const LinearTolerance& tolerance,
                          const Precondition& precondition, Nodes* x, LinearReport* report) {
  const double goal = std::max(tolerance.absolute, tolerance.relative * norm(b, weight));
  r_ = of_p_ = b;
  p_ = z_ = *x;
  x->setZero();
  double rz = dot(r_, z_);
  report->solved = false;
  for (int k = 0; k < tolerance.iterations && rz > 0.0; ++k) {
    q_ = of_p_;
    add_beside_diagonal([](int node) { return node; }, p_, &q_);
    const double curvature = dot(p_, q_);
    if (!(curvature > 0.0)) break;
    const double alpha = rz / curvature;
    *x += alpha * p_;
    before_ = r_;
    r_ -= alpha * q_;
    ++report->iterations;
    report->solved = norm(r_, weight) <= goal;
    if (report->solved || !precondition(r_, &z_)) return;
    const double now = dot(r_, z_), beta = std::max(0.0, (now - dot(before_, z_)) / rz);
    p_ = z_ + beta * p_;
    of_p_ = r_ + beta * of_p_;
    rz = dot(r_, p_);
  }
}

}  // namespace deformable_sim
