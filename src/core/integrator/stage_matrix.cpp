#include "deformable_sim/core/integrator/stage_matrix.h"

#include <algorithm>
#include <cassert>
#include <functional>
#include <utility>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/linear/multigrid_solver.h"

namespace deformable_sim {
namespace {

constexpr double kInner = 1e-3;  // relative residual of a solve that preconditions

std::unique_ptr<LinearSolver> make_solver(SolverSettings::Linear linear) {
  switch (linear) {
    case SolverSettings::Linear::kDirect:
      return make_direct_solver();
    case SolverSettings::Linear::kBanded:
      return make_banded_solver();
    case SolverSettings::Linear::kConjugateGradient:
    case SolverSettings::Linear::kMultigrid:  // where links stay apart
      break;
  }
  return make_conjugate_gradient_solver();
}

}  // namespace

StageMatrix::StageMatrix(const SolverSettings& settings, Links links) {
  if (links == Links::kInBlocks) {
    solver_ = make_solver(settings.linear);
    return;
  }
  std::unique_ptr<MultigridSolver> multigrid = make_multigrid_solver();
  multigrid_ = multigrid.get();
  solver_ = std::move(multigrid);
}

void StageMatrix::reset() {
  pattern_ = nullptr;
  sorted_energies_.clear();
  if (multigrid_ != nullptr) multigrid_->forget();
}

void StageMatrix::renew(const Dynamics& d, double tau) {
  dynamics_ = &d;
  tau_ = tau;
  if (pattern_ != d.pattern || matrix_.rows() != d.pattern->rows()) {
    pattern_ = d.pattern;
    matrix_ = *pattern_;
    stale_ = true;
    mass_matrix_ = nullptr;
    held_.clear();
    find_held_slots();
  }
  if (held_ != d.kinematics.node) {
    find_held_slots();
    stale_ = true;
  }
  if (mass_matrix_ != d.mass_matrix) find_mass_slots();
  if (prepared_tau_ != tau_ || prepared_energies_ != d.energies) stale_ = true;
  if (sorted_energies_ != d.energies) sort_terms();
  if (stale_ && multigrid_ != nullptr) multigrid_->set_links(links_, tau_, held_);
}

void StageMatrix::find_held_slots() {
  held_ = dynamics_->kinematics.node;
  held_slots_.clear();
  for (int i : held_) {
    for (int k = matrix_.row_start()[static_cast<size_t>(i)]; k < matrix_.row_start()[static_cast<size_t>(i) + 1];
         ++k) {
      held_slots_.push_back(k);
      held_slots_.push_back(matrix_.slot(matrix_.column()[static_cast<size_t>(k)], i));
    }
  }
}

void StageMatrix::find_mass_slots() {
  mass_matrix_ = dynamics_->mass_matrix;
  stale_ = true;
  mass_slots_.clear();
  if (mass_matrix_ == nullptr) return;
  for (int j = 0; j < mass_matrix_->outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(*mass_matrix_, j); it; ++it) {
      mass_slots_.push_back(matrix_.slot(static_cast<int>(it.row()), j));
      assert(mass_slots_.back() >= 0);
    }
  }
}

void StageMatrix::set_inertia(const std::vector<int>& near, double tau_near) {
  matrix_.set_zero();
  if (mass_matrix_ != nullptr) {
    share_.assign(static_cast<size_t>(matrix_.rows()), 1.0);
    for (int i : near) share_[static_cast<size_t>(i)] = tau_ / tau_near;
    const int* slot = mass_slots_.data();
    for (int j = 0; j < mass_matrix_->outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(*mass_matrix_, j); it; ++it) {
        const double share = share_[static_cast<size_t>(it.row())] * share_[static_cast<size_t>(j)];
        matrix_.block(*slot++).diagonal().setConstant(share * it.value() / (tau_ * tau_));
      }
    }
    return;
  }
  for (int i = 0; i < matrix_.rows(); ++i) {
    matrix_.block(matrix_.diagonal_slot(i)).diagonal().setConstant((*dynamics_->mass)[i] / (tau_ * tau_));
  }
  for (int i : near) {
    matrix_.block(matrix_.diagonal_slot(i)).diagonal().setConstant((*dynamics_->mass)[i] / (tau_near * tau_near));
  }
}

void StageMatrix::add_forces(const State& s, double dx, double dv, Jacobian kind) {
  if (multigrid_ != nullptr) {
    using Transverse = MultigridSolver::Transverse;
    multigrid_->place_springs(s.x, dx, dv, kind == Jacobian::kAxial ? Transverse::kNone : Transverse::kProjected);
  }
  for (const Energy* energy : in_blocks_) energy->add_jacobian(s, dx, dv, kind, &matrix_);
}

void StageMatrix::make_symmetric() {
  for (int i = 0; i < matrix_.rows(); ++i) {
    for (int k = matrix_.row_start()[static_cast<size_t>(i)]; k < matrix_.row_start()[static_cast<size_t>(i) + 1];
         ++k) {
      const int j = matrix_.column()[static_cast<size_t>(k)];
      if (j < i) continue;
      const int mirror = matrix_.slot(j, i);
      const Mat3 mean = 0.5 * (matrix_.block(k) + matrix_.block(mirror).transpose());
      matrix_.block(k) = mean;
      matrix_.block(mirror) = mean.transpose();
    }
  }
}

void StageMatrix::hold() {
  for (int slot : held_slots_) matrix_.block(slot).setZero();
  for (int node : held_) matrix_.block(matrix_.diagonal_slot(node)).setIdentity();
}

/// What is assembled, and what the solver is told of instead.
void StageMatrix::sort_terms() {
  sorted_energies_ = in_blocks_ = dynamics_->energies;
  if (multigrid_ == nullptr) return;
  links_.clear();
  for (const Energy* energy : dynamics_->energies) {
    if (const ConstantLinks* links = energy->constant_links()) links_.push_back(links);
  }
  std::vector<SpringElement> springs;
  for (const KnownSpring& s : take_springs(&in_blocks_).springs) {
    springs.push_back({s.a, s.b, s.length, s.stiffness, s.damping});
  }
  in_blocks_.erase(std::remove_if(in_blocks_.begin(), in_blocks_.end(),
                                  [](const Energy* energy) { return energy->constant_links() != nullptr; }),
                   in_blocks_.end());
  multigrid_->set_springs(springs);
}

LinearReport StageMatrix::solve(const Nodes& b, const Eigen::VectorXd& weight, const LinearTolerance& tolerance,
                                Nodes* step, StepReport* report) {
  if (stale_) {
    solver_->prepare(matrix_);
    prepared_tau_ = tau_;
    prepared_energies_ = dynamics_->energies;
    stale_ = false;
  }
  step->setZero();
  const bool taken = !couplings_.empty() && solver_->take(&couplings_);
  LinearReport linear = solver_->solve(matrix_, b, weight, tolerance, step);
  if (taken) solver_->take(nullptr);
  for (int node : held_) step->col(node).setZero();
  if (!couplings_.empty() && !taken && linear.definite) {
    const LinearTolerance inner = {kInner, 0.0, tolerance.iterations};
    const auto precondition = [&](const Nodes& r, Nodes* z) {
      if (linear.kept) return solve_again(r, z);
      z->setZero(3, r.cols());
      const LinearReport part = solver_->solve(matrix_, r, weight, inner, z);
      linear.iterations += part.iterations;
      for (int node : held_) z->col(node).setZero();
      return part.definite;
    };
    couplings_.solve(b, weight, tolerance, std::cref(precondition), step, &linear);  // by reference: no allocation
  }
  report->linear_iterations += linear.iterations;
  return linear;
}

bool StageMatrix::solve_again(const Nodes& b, Nodes* step) {
  if (!solver_->solve_again(b, step)) return false;
  for (int node : held_) step->col(node).setZero();
  return true;
}

}  // namespace deformable_sim
