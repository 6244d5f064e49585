// What tests of sheets measure: areas, masses, frequencies and stiffness across the plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "deformable_sim/core/topology/triangle_mesh.h"
#include "support/system.h"

namespace deformable_sim::test {

inline Eigen::VectorXd face_areas(const TriangleMesh& mesh) {
  Eigen::VectorXd areas(static_cast<Eigen::Index>(mesh.triangles.size()));
  for (size_t k = 0; k < mesh.triangles.size(); ++k) {
    const auto& t = mesh.triangles[k];
    const Vec3 a = mesh.rest.col(t[1]) - mesh.rest.col(t[0]), b = mesh.rest.col(t[2]) - mesh.rest.col(t[0]);
    areas[static_cast<Eigen::Index>(k)] = 0.5 * a.cross(b).norm();
  }
  return areas;
}

/// A third of each triangle (kg), of `density` kg/m^2.
inline Eigen::VectorXd triangle_masses(const TriangleMesh& mesh, double density) {
  const Eigen::VectorXd areas = face_areas(mesh);
  Eigen::VectorXd masses = Eigen::VectorXd::Zero(mesh.rest.cols());
  for (size_t k = 0; k < mesh.triangles.size(); ++k) {
    for (const int i : mesh.triangles[k]) masses[i] += density * areas[static_cast<Eigen::Index>(k)] / 3.0;
  }
  return masses;
}

/// How far a node lies from the sides of the rectangle around the mesh, m.
inline double distance_to_border(const TriangleMesh& mesh, int node) {
  const Vec3 low = mesh.rest.rowwise().minCoeff(), high = mesh.rest.rowwise().maxCoeff(), p = mesh.rest.col(node);
  return std::min({p.x() - low.x(), high.x() - p.x(), p.y() - low.y(), high.y() - p.y()});
}

inline bool on_border(const TriangleMesh& mesh, int node) {
  return distance_to_border(mesh, node) < 1e-9;
}

/// -d f_z / d z at the system's state, one row a free node.
template <class Held>
Eigen::MatrixXd stiffness_across(System* system, const Held& held, std::vector<int>* free) {
  if (system->dynamics.pattern == nullptr) system->build_pattern();
  system->pattern.set_zero();
  for (const Energy* term : system->dynamics.energies) {
    term->add_jacobian(system->state, 1.0, 0.0, Jacobian::kExact, &system->pattern);
  }
  free->clear();
  for (int i = 0; i < system->mass.size(); ++i) {
    if (!held(i)) free->push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(free->size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const int slot = system->pattern.slot((*free)[static_cast<size_t>(i)], (*free)[static_cast<size_t>(j)]);
      if (slot >= 0) k(i, j) = system->pattern.block(slot)(2, 2);
    }
  }
  return k;
}

/// Natural frequencies (rad/s) of small motions along z, ascending.
template <class Held>
Eigen::VectorXd normal_frequencies(System* system, const Held& held) {
  std::vector<int> free;
  Eigen::MatrixXd k = stiffness_across(system, held, &free);
  for (Eigen::Index i = 0; i < k.rows(); ++i) {
    for (Eigen::Index j = 0; j < k.cols(); ++j) {
      k(i, j) /= std::sqrt(system->mass[free[static_cast<size_t>(i)]] * system->mass[free[static_cast<size_t>(j)]]);
    }
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

}  // namespace deformable_sim::test
