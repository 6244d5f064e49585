// Static equilibria of a System by Newton's method on the energy: no time step, no mass.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/SparseCholesky>

#include "support/system.h"

namespace deformable_sim::test {

struct Equilibrium {
  bool converged = false;  // residual <= tolerance
  bool stable = false;     // the exact Hessian is positive definite at the end: a minimum, not a saddle
  int iterations = 0;      // Newton steps
  double residual = 0.0;   // N, largest unbalanced force component of a free coordinate
};

struct StaticSettings {
  double tolerance = 1e-9;                  // N, of the residual
  int iterations = 200;                     // Newton steps, at most
  double largest_move = 0.0;                // m, of a coordinate in one Newton step; 0 = no limit
  std::vector<std::array<int, 2>> rollers;  // {node, axis}: coordinates held where they are, beside the held nodes
};

/// Minimises the sum of the energies of a system over its free coordinates. Held nodes go to their targets first.
///
/// A Newton step solves H dx = f with the exact Hessian where that is positive definite, else with the projected one,
/// shifted by a growing multiple of its mean diagonal until it is; the step is halved until the energy falls by 1e-4 of
/// what the slope promises (where that is below the round-off of the energy: until the residual falls). Coordinates
/// that nothing acts on (the unused ones of an angle's column) stay. State kept by terms is carried along (end_step).
/// Only for terms that have an energy: dampers do not act at rest, drag does not belong here.
class StaticSolver {
 public:
  StaticSolver(System* system, const StaticSettings& settings) : system_(*system), settings_(settings) {}

  Equilibrium solve() {
    if (system_.dynamics.pattern == nullptr) system_.build_pattern();
    system_.state.v.setZero();
    hold();
    Equilibrium result;
    for (;; ++result.iterations) {
      const Eigen::VectorXd f = free_forces(system_.state);
      result.residual = f.size() > 0 ? f.lpNorm<Eigen::Infinity>() : 0.0;
      result.converged = result.residual <= settings_.tolerance;
      if (result.converged || result.iterations == settings_.iterations || !step(f)) break;
    }
    factorise(Jacobian::kExact, 0.0);
    result.stable = factor_.info() == Eigen::Success;
    report_reactions();
    return result;
  }

 private:
  using Factor = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>;

  void hold() {
    held_.assign(static_cast<size_t>(system_.state.x.size()), 0);
    const Kinematics& k = system_.dynamics.kinematics;
    for (size_t i = 0; i < k.node.size(); ++i) {
      system_.state.x.col(k.node[i]) = k.target.col(static_cast<Eigen::Index>(i));
      for (int axis = 0; axis < 3; ++axis) held_[static_cast<size_t>(3 * k.node[i] + axis)] = 1;
    }
    for (const auto& [node, axis] : settings_.rollers) held_[static_cast<size_t>(3 * node + axis)] = 1;
  }

  Nodes forces(const State& s) const {
    Nodes f = Nodes::Zero(3, s.x.cols());
    for (const Energy* term : system_.dynamics.energies) term->add_force(s, &f);
    return f;
  }

  Eigen::VectorXd free_forces(const State& s) const {
    const Nodes all = forces(s);
    Eigen::VectorXd f = Eigen::Map<const Eigen::VectorXd>(all.data(), all.size());
    for (Eigen::Index k = 0; k < f.size(); ++k) {
      if (held_[static_cast<size_t>(k)]) f[k] = 0.0;
    }
    return f;
  }

  double energy(const State& s) const {
    double sum = 0.0;
    for (const Energy* term : system_.dynamics.energies) sum += term->value(s);
    return sum;
  }

  /// Factor of H + shift I over the free coordinates; success shows in factor_.info().
  void factorise(Jacobian kind, double shift) {
    system_.pattern.set_zero();
    for (const Energy* term : system_.dynamics.energies) {
      term->add_jacobian(system_.state, 1.0, 0.0, kind, &system_.pattern);
    }
    Eigen::SparseMatrix<double> h = system_.pattern.to_sparse();
    Eigen::VectorXd empty_row = Eigen::VectorXd::Ones(h.rows());
    diagonal_ = 0.0;
    for (Eigen::Index k = 0; k < h.outerSize(); ++k) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(h, k); it; ++it) {
        if (held_[static_cast<size_t>(it.row())] || held_[static_cast<size_t>(it.col())]) it.valueRef() = 0.0;
        if (it.value() != 0.0) empty_row[it.row()] = 0.0;
        if (it.row() == it.col()) diagonal_ += std::abs(it.value()) / static_cast<double>(h.rows());
      }
    }
    for (Eigen::Index k = 0; k < h.rows(); ++k) h.coeffRef(k, k) += empty_row[k] > 0.0 ? 1.0 : shift;
    if (!analysed_) factor_.analyzePattern(h);
    analysed_ = true;
    factor_.factorize(h);
  }

  /// One Newton step; false when no step along the direction found lowers the energy.
  bool step(const Eigen::VectorXd& f) {
    factorise(Jacobian::kExact, 0.0);
    for (double shift = 0.0; factor_.info() != Eigen::Success; shift = std::max(4.0 * shift, 1e-8)) {
      if (shift > 1e8) return false;
      factorise(Jacobian::kProjected, shift * diagonal_);
    }
    Eigen::VectorXd dx = factor_.solve(f);
    const double longest = dx.lpNorm<Eigen::Infinity>();
    if (settings_.largest_move > 0.0 && longest > settings_.largest_move) dx *= settings_.largest_move / longest;
    return search(f, dx);
  }

  bool search(const Eigen::VectorXd& f, const Eigen::VectorXd& dx) {
    const double start = energy(system_.state), slope = f.dot(dx), residual = f.lpNorm<Eigen::Infinity>();
    const bool below_round_off = slope < 1e-10 * std::abs(start) || slope < 1e-290;
    State trial = system_.state;
    for (double length = 1.0; length > 1e-12; length *= 0.5) {
      trial.x = system_.state.x + length * Eigen::Map<const Nodes>(dx.data(), 3, trial.x.cols());
      const double end = energy(trial);
      if (!std::isfinite(end)) continue;
      const bool accepted = end <= start - 1e-4 * length * slope ||
                            (below_round_off && free_forces(trial).lpNorm<Eigen::Infinity>() < residual);
      if (!accepted) continue;
      for (const Energy* term : system_.dynamics.energies) term->end_step(&trial);
      system_.state = trial;
      return true;
    }
    return false;
  }

  void report_reactions() {
    Kinematics& k = system_.dynamics.kinematics;
    const Nodes f = forces(system_.state);
    k.reaction.resize(3, static_cast<Eigen::Index>(k.node.size()));
    for (size_t i = 0; i < k.node.size(); ++i) k.reaction.col(static_cast<Eigen::Index>(i)) = -f.col(k.node[i]);
  }

  System& system_;
  StaticSettings settings_;
  std::vector<char> held_;  // per coordinate
  double diagonal_ = 0.0;   // mean of |H_kk|
  bool analysed_ = false;
  Factor factor_;
};

inline Equilibrium find_equilibrium(System* system, const StaticSettings& settings = {}) {
  return StaticSolver(system, settings).solve();
}

}  // namespace deformable_sim::test
