// A System about the state it is in: stiffness matrix, small motions, small loads.
#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "support/system.h"

namespace deformable_sim::test {

/// K = -df/dx, exact, 3n x 3n (N/m); coordinate 3 node + axis.
inline Eigen::MatrixXd stiffness_matrix(System* system) {
  if (system->dynamics.pattern == nullptr) system->build_pattern();
  system->pattern.set_zero();
  for (const Energy* term : system->dynamics.energies)
    term->add_jacobian(system->state, 1.0, 0.0, Jacobian::kExact, &system->pattern);
  return Eigen::MatrixXd(system->pattern.to_sparse());
}

/// Coordinates along `axes` of the nodes first ... last.
inline std::vector<int> coordinates(int first, int last, const std::vector<int>& axes) {
  std::vector<int> found;
  for (int node = first; node <= last; ++node)
    for (int axis : axes) found.push_back(3 * node + axis);
  return found;
}

inline Eigen::MatrixXd part_of(const Eigen::MatrixXd& k, const std::vector<int>& rows,
                               const std::vector<int>& columns) {
  Eigen::MatrixXd part(rows.size(), columns.size());
  for (size_t i = 0; i < rows.size(); ++i)
    for (size_t j = 0; j < columns.size(); ++j)
      part(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = k(rows[i], columns[j]);
  return part;
}

/// Natural frequencies (rad/s), ascending, of motions of the coordinates `free`; the others are held.
inline Eigen::VectorXd natural_frequencies(System* system, const std::vector<int>& free) {
  Eigen::MatrixXd k = part_of(stiffness_matrix(system), free, free);
  for (size_t i = 0; i < free.size(); ++i) {
    const double root = std::sqrt(system->mass[free[i] / 3]);
    k.row(static_cast<Eigen::Index>(i)) /= root;
    k.col(static_cast<Eigen::Index>(i)) /= root;
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

/// Small displacements (3 x n, m) under `force` (N), with the coordinates not in `free` held at `prescribed`.
inline Nodes linear_displacement(System* system, const std::vector<int>& free, const Nodes& force,
                                 const Nodes& prescribed) {
  const Eigen::MatrixXd k = stiffness_matrix(system);
  Nodes u = prescribed;
  for (int c : free) u.data()[c] = 0.0;
  const Eigen::VectorXd reaction = k * Eigen::Map<const Eigen::VectorXd>(u.data(), u.size());
  Eigen::VectorXd b(free.size());
  for (size_t i = 0; i < free.size(); ++i) b[static_cast<Eigen::Index>(i)] = force.data()[free[i]] - reaction[free[i]];
  const Eigen::VectorXd x = part_of(k, free, free).ldlt().solve(b);
  for (size_t i = 0; i < free.size(); ++i) u.data()[free[i]] = x[static_cast<Eigen::Index>(i)];
  return u;
}

}  // namespace deformable_sim::test
