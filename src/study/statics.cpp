#include "statics.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace deformable_sim::study {
namespace {

using Vector = Eigen::VectorXd;

class Search {
 public:
  Search(const std::vector<std::unique_ptr<Energy>>& energies, const std::vector<char>& held, double force_scale,
         const StaticsSettings& settings, State* state)
      : energies_(energies), held_(held), force_scale_(force_scale), settings_(settings), state_(*state) {
    std::vector<std::array<int, 2>> pairs;
    for (const auto& e : energies_) e->add_pattern(&pairs);
    matrix_ = BlockMatrix(static_cast<int>(state_.x.cols()), pairs);
    for (const auto& e : energies_) e->bind(matrix_);
    state_.v.setZero(3, state_.x.cols());
  }

  Equilibrium run() {
    Equilibrium result;
    Vector f = free_forces(state_, &result.residual);
    for (; result.iterations < settings_.iterations; ++result.iterations) {
      result.converged = result.residual <= settings_.tolerance;
      if (result.converged) break;
      assemble();
      if (!step(f, result.residual)) break;
      f = free_forces(state_, &result.residual);
    }
    // Below the round-off of the energy no step can be judged: a residual that is small all the same counts.
    result.converged = result.residual <= 1e3 * settings_.tolerance;
    return result;
  }

 private:
  double energy(const State& s) const {
    double sum = 0.0;
    for (const auto& e : energies_) sum += e->value(s);
    return sum;
  }

  Vector free_forces(const State& s, double* residual) const {
    const Nodes all = forces_of(energies_, s);
    Vector f = Eigen::Map<const Vector>(all.data(), all.size());
    double largest = force_scale_, unbalanced = 0.0;
    for (Eigen::Index k = 0; k < f.size(); ++k) {
      const bool is_held = held_[static_cast<size_t>(k)] != 0;
      double& of_kind = is_held ? largest : unbalanced;
      of_kind = std::max(of_kind, std::abs(f[k]));
      if (is_held) f[k] = 0.0;
    }
    *residual = largest > 0.0 ? unbalanced / largest : 0.0;
    return f;
  }

  /// Hessian over the free coordinates; identity where nothing acts or the coordinate is held.
  void assemble() {
    matrix_.set_zero();
    for (const auto& e : energies_) e->add_jacobian(state_, 1.0, 0.0, Jacobian::kExact, &matrix_);
    hessian_ = matrix_.to_sparse();
    const Eigen::Index n = hessian_.rows();
    Vector idle = Vector::Ones(n);
    diagonal_ = 0.0;
    for (Eigen::Index c = 0; c < n; ++c) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(hessian_, c); it; ++it) {
        if (held_[static_cast<size_t>(it.row())] || held_[static_cast<size_t>(c)]) it.valueRef() = 0.0;
        if (it.value() != 0.0) idle[it.row()] = 0.0;
        if (it.row() == c) diagonal_ += std::abs(it.value()) / static_cast<double>(n);
      }
    }
    if (diagonal_ == 0.0) diagonal_ = 1.0;
    for (Eigen::Index k = 0; k < n; ++k) hessian_.coeffRef(k, k) += idle[k] * diagonal_;
  }

  bool factorise(double shift) {
    if (!analysed_) factor_.analyzePattern(hessian_);
    analysed_ = true;
    factor_.setShift(shift);
    factor_.factorize(hessian_);
    return factor_.info() == Eigen::Success;
  }

  /// Moves the state; false when no step lowers the energy any more.
  bool step(const Vector& f, double residual) {
    const double least = 1e-10 * diagonal_, start = energy(state_);
    State trial = state_;
    for (int attempt = 0; attempt < 60; ++attempt) {
      if (!factorise(shift_)) {
        shift_ = std::max(4.0 * shift_, 100.0 * least);
        continue;
      }
      Vector dx = factor_.solve(f);
      const double longest = dx.lpNorm<Eigen::Infinity>();
      if (settings_.longest_move > 0.0 && longest > settings_.longest_move) dx *= settings_.longest_move / longest;
      trial.x = state_.x + Eigen::Map<const Nodes>(dx.data(), 3, state_.x.cols());
      const double promised = f.dot(dx) - 0.5 * dx.dot(hessian_ * dx), fell = start - energy(trial);
      double at_trial = 0.0;
      const bool below_round_off = std::abs(promised) < 1e-11 * std::abs(start) + 1e-300;
      if (below_round_off) free_forces(trial, &at_trial);
      if (below_round_off ? at_trial < residual : (std::isfinite(fell) && fell > 0.1 * promised)) {
        for (const auto& e : energies_) e->end_step(&trial);
        state_ = trial;
        if (fell > 0.7 * promised || below_round_off) shift_ = shift_ > 100.0 * least ? shift_ / 8.0 : 0.0;
        return true;
      }
      if (below_round_off) return false;
      shift_ = std::max(4.0 * shift_, 100.0 * least);
    }
    return false;
  }

  const std::vector<std::unique_ptr<Energy>>& energies_;
  const std::vector<char>& held_;
  double force_scale_;
  StaticsSettings settings_;
  State& state_;
  BlockMatrix matrix_;
  Eigen::SparseMatrix<double> hessian_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool analysed_ = false;
  double diagonal_ = 1.0;  // mean of |H_kk|, N/m
  double shift_ = 0.0;     // N/m
};

}  // namespace

Nodes forces_of(const std::vector<std::unique_ptr<Energy>>& energies, const State& state) {
  Nodes f = Nodes::Zero(3, state.x.cols());
  for (const auto& e : energies) e->add_force(state, &f);
  return f;
}

Equilibrium settle(const std::vector<std::unique_ptr<Energy>>& energies, const std::vector<char>& held,
                   double force_scale, const StaticsSettings& settings, State* state) {
  return Search(energies, held, force_scale, settings, state).run();
}

}  // namespace deformable_sim::study
