#include "deformable_sim/core/integrator/mass_factor.h"

#include "deformable_sim/core/error.h"

namespace deformable_sim {

void MassFactor::prepare(const Eigen::SparseMatrix<double>& mass, const std::vector<int>& held) {
  if (mass_ == &mass && held_ == held) return;
  mass_ = &mass;
  held_ = held;
  std::vector<char> is_held(static_cast<size_t>(mass.rows()), 0);
  for (int node : held) is_held[static_cast<size_t>(node)] = 1;
  Eigen::SparseMatrix<double> free = mass;
  free.prune([&](Eigen::Index i, Eigen::Index j, double) {
    return i == j || (is_held[static_cast<size_t>(i)] == 0 && is_held[static_cast<size_t>(j)] == 0);
  });
  factor_.compute(free);
  if (factor_.info() != Eigen::Success) throw InputError("the mass matrix is not positive definite");
  work_.resize(mass.rows(), 3);
}

void MassFactor::release(Nodes* f) const {
  for (int node : held_) f->col(node).setZero();
}

void MassFactor::solve_lower(Nodes* q) {
  release(q);
  const auto& position = factor_.permutationP().indices();
  for (Eigen::Index i = 0; i < q->cols(); ++i) work_.row(position[i]) = q->col(i).transpose();
  factor_.matrixL().solveInPlace(work_);
  *q = work_.transpose();
}

void MassFactor::solve_upper(Nodes* q) {
  work_ = q->transpose();
  factor_.matrixU().solveInPlace(work_);
  const auto& position = factor_.permutationP().indices();
  for (Eigen::Index i = 0; i < q->cols(); ++i) q->col(i) = work_.row(position[i]).transpose();
  release(q);
}

void MassFactor::solve(Nodes* f) {
  solve_lower(f);
  solve_upper(f);
}

void add_prescribed_inertia(double dt, const Eigen::SparseMatrix<double>& mass, const Kinematics& kinematics,
                            const Nodes& x, const Nodes& v, Nodes* f) {
  for (size_t k = 0; k < kinematics.node.size(); ++k) {
    const int node = kinematics.node[k];
    const Vec3 speed = (kinematics.target.col(static_cast<Eigen::Index>(k)) - x.col(node)) / dt;
    const Vec3 acceleration = (speed - v.col(node)) / dt;
    for (Eigen::SparseMatrix<double>::InnerIterator it(mass, node); it; ++it) {
      f->col(it.row()) -= it.value() * acceleration;
    }
  }
}

}  // namespace deformable_sim
