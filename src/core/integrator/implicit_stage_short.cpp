// Implicit steps so short that positions are too coarse for what they move by.
#include <cmath>
#include <limits>

#include "deformable_sim/core/integrator/implicit_stage.h"

namespace deformable_sim {
namespace {

constexpr double kShort = 1e-5;       // s: no longer step is looked at for ...
constexpr double kUnresolved = 0.01;  // m/s^2: ... positions so coarse that differences of them hide this much

}  // namespace

bool is_unresolved(double tau, const State& start, const Dynamics& d) {
  if (tau > kShort || !d.contacts.empty() || d.mass_matrix != nullptr) return false;
  const double round_off = std::numeric_limits<double>::epsilon() * start.x.cwiseAbs().maxCoeff();
  return round_off > kUnresolved * tau * tau;
}

/// v = v_base + tau M^-1 (f(x_base + tau v, v) + more_force) by fixed-point iteration, in which no position is taken
/// from another: what a round leaves shrinks by (omega tau)^2, which is next to nothing in steps so short.
StepReport ImplicitStage::solve_for_velocities() {
  StepReport report;
  trial_.v = (trial_.x - *equation_.x_base) / tau_;  // of held nodes
  find_force(*start_, *dynamics_, &force_);
  report.converged = false;
  while (!report.converged && report.newton_iterations < settings_.newton_iterations) {
    before_ = force_;
    if (equation_.more_force != nullptr) before_ += *equation_.more_force;
    for (Eigen::Index i = 0; i < before_.cols(); ++i) {
      if (inverse_mass_[i] == 0.0) continue;
      trial_.v.col(i) = equation_.v_base->col(i) + tau_ * inverse_mass_[i] * before_.col(i);
      trial_.x.col(i) = equation_.x_base->col(i) + tau_ * trial_.v.col(i);
    }
    find_force(trial_, *dynamics_, &force_);
    base_ = (trial_.v - *equation_.v_base) * (*dynamics_->mass / tau_).asDiagonal() - force_;
    if (equation_.more_force != nullptr) base_ -= *equation_.more_force;
    residual_ = force_ - before_;
    if (equation_.more_force != nullptr) residual_ += *equation_.more_force;
    report.residual = unbalanced(residual_);
    report.converged = report.residual <= settings_.tolerance;
    ++report.newton_iterations;
  }
  report.force_evaluations = report.newton_iterations + 1;
  report.seconds_assembly = lap();
  return report;
}

}  // namespace deformable_sim
