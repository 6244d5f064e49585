// Checks every derivative a force term delivers, at one state.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/energy/energy.h"

namespace deformable_sim::test {

inline Nodes force_of(const Energy& term, const State& s) {
  Nodes f = Nodes::Zero(3, s.x.cols());
  term.add_force(s, &f);
  return f;
}

/// Central differences of the force: dx df/dx + dv df/dv, one column a coordinate.
inline Eigen::MatrixXd difference_jacobian(const Energy& term, const State& s, double dx, double dv) {
  const Eigen::Index n = 3 * s.x.cols();
  const double h = 1e-6;
  Eigen::MatrixXd jacobian(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(n);
    for (const double sign : {1.0, -1.0}) {
      State moved = s, sped = s;
      moved.x.data()[k] += sign * h;
      sped.v.data()[k] += sign * h;
      const Nodes by_x = force_of(term, moved), by_v = force_of(term, sped);
      column += sign / (2.0 * h) *
                (dx * Eigen::Map<const Eigen::VectorXd>(by_x.data(), n) +
                 dv * Eigen::Map<const Eigen::VectorXd>(by_v.data(), n));
    }
    jacobian.col(k) = column;
  }
  return jacobian;
}

inline Eigen::MatrixXd delivered_jacobian(const Energy& term, const State& s, double dx, double dv, Jacobian kind,
                                          BlockMatrix* matrix) {
  matrix->set_zero();
  term.add_jacobian(s, dx, dv, kind, matrix);
  return -Eigen::MatrixXd(matrix->to_sparse());
}

/// force = -dE/dx of conservative terms; Jacobians exact to 1e-6; exact symmetric in x when conservative; projected
/// symmetric and negative semi-definite.
inline void check_derivatives(Energy* term, const State& s, bool conservative) {
  SCOPED_TRACE(term->name());
  const auto n = static_cast<int>(s.x.cols());
  std::vector<std::array<int, 2>> pairs;
  term->add_pattern(&pairs);
  BlockMatrix matrix(n, pairs);
  term->bind(matrix);

  State still = s;
  still.v.setZero();  // a conservative term may damp as well
  if (conservative) {
    const Nodes force = force_of(*term, still);
    const double h = 1e-6;
    for (Eigen::Index k = 0; k < force.size(); ++k) {
      State plus = still, minus = still;
      plus.x.data()[k] += h;
      minus.x.data()[k] -= h;
      const double slope = (term->value(plus) - term->value(minus)) / (2.0 * h);
      EXPECT_NEAR(force.data()[k], -slope, 1e-6 * (1.0 + force.norm())) << "coordinate " << k;
    }
  } else {
    EXPECT_EQ(term->value(s), 0.0);
  }

  for (const auto& [dx, dv] : {std::array<double, 2>{1.0, 0.0}, {0.0, 1.0}, {0.7, 20.0}}) {
    const Eigen::MatrixXd expected = difference_jacobian(*term, s, dx, dv);
    const Eigen::MatrixXd exact = delivered_jacobian(*term, s, dx, dv, Jacobian::kExact, &matrix);
    const double scale = expected.norm() + 1e-9;
    EXPECT_LT((exact - expected).norm(), 1e-6 * scale) << "dx " << dx << ", dv " << dv;

    const Eigen::MatrixXd projected = delivered_jacobian(*term, s, dx, dv, Jacobian::kProjected, &matrix);
    EXPECT_LT((projected - projected.transpose()).norm(), 1e-14 * scale);
    const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(projected).eigenvalues().maxCoeff();
    EXPECT_LT(largest, 1e-12 * scale);
  }
  if (conservative) {
    const Eigen::MatrixXd exact = delivered_jacobian(*term, still, 1.0, 0.0, Jacobian::kExact, &matrix);
    EXPECT_LT((exact - exact.transpose()).norm(), 1e-14 * (exact.norm() + 1e-9));
  }
}

}  // namespace deformable_sim::test
