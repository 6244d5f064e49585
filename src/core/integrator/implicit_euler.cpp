// Implicit (backward) Euler by Newton's method.
//
// The unknown is x, the positions at the end of the step. The residual
//
//   r(x) = M (x - x0 - dt v0) / dt^2 - f(x, (x - x0) / dt) - contacts(x)
//
// is made small from x0 or from the explicit step x0 + dt v0 + dt^2 M^-1 f(x0, v0), whichever has the smaller residual:
// a body at rest starts from x0, so that an unconverged step cannot drift away from an equilibrium.
// The matrix is M / dt^2 - df/dx - df/dv / dt, projected, so that every Newton direction is a descent direction.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "deformable_sim/core/integrator/cpu_time.h"
#include "deformable_sim/core/integrator/penalty_contacts.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "deformable_sim/core/linear/linear_solver.h"

namespace deformable_sim {
namespace {

constexpr double kEnough = 0.9;      // a step may turn p.r round by this much ...
constexpr double kMostGrowth = 1.5;  // ... or leave this much of it
constexpr double kInexact = 0.3;     // beyond this, the secant is tried
constexpr double kFarthest = 4.0;    // of a secant, in units of the Newton step
constexpr double kLeastLeft = 1.0 - 1.0 / kFarthest;
constexpr int kHalvings = 8;            // of a Newton step, at most
constexpr double kLinearShare = 0.3;    // of the Newton tolerance that the linear solve may leave
constexpr double kAtRest = 1e-3;        // of the tolerance: below, a step may take no Newton iteration at all
constexpr int kFrictionIterations = 5;  // Newton iterations in which friction follows the normal force
constexpr double kDeep = 3e-4;          // m: while a contact point is deeper ...
constexpr double kRough = 60.0;         // m/s^2: ... or the residual of a step with contacts larger, Newton goes on ...
constexpr int kRoughShare = 2;          // ... for at most so many times the allowed iterations

class ImplicitEuler : public Integrator {
 public:
  explicit ImplicitEuler(const SolverSettings& settings)
      : settings_(settings),
        solver_(settings.linear == SolverSettings::Linear::kDirect ? make_direct_solver()
                                                                   : make_conjugate_gradient_solver()) {}

  std::string name() const override { return "implicit_euler"; }
  Needs needs() const override { return {true}; }
  int order() const override { return 1; }
  double stability_limit() const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { pattern_ = nullptr; }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    StepReport report;
    const double start = thread_cpu_time();
    begin(dt, *d, *s);
    report.residual = start_iteration();
    report.seconds_assembly = thread_cpu_time() - start;
    const double enough = settings_.tolerance;
    report.converged = report.residual <= kAtRest * enough;
    const int most = settings_.newton_iterations;
    for (int k = 0; k < most || (k < kRoughShare * most && is_rough(report)); ++k) {
      if (report.converged) break;
      assemble(&report);
      if (!solve(&report)) break;
      const double search = thread_cpu_time();
      search_along_step();
      if (!contacts_.empty() && k < kFrictionIterations) {
        contacts_.update_normal_forces(trial_.x);
        add_contacts();
      }
      report.seconds_assembly += thread_cpu_time() - search;
      ++report.newton_iterations;
      report.residual = unbalanced(residual_);
      report.converged = report.residual <= enough;
    }
    if (!report.converged) contacts_.push_out(kDeep, inverse_mass_, &trial_.x);
    finish(d, s);
    report.converged = report.converged && s->finite();
    return report;
  }

 private:
  void begin(double dt, const Dynamics& d, const State& s) {
    dt_ = dt;
    dynamics_ = &d;
    start_ = &s;
    const Eigen::Index n = s.x.cols();
    inverse_mass_ = d.mass->cwiseInverse();
    for (int node : d.kinematics.node) inverse_mass_[node] = 0.0;
    free_ = static_cast<double>(std::max<Eigen::Index>(1, n - static_cast<Eigen::Index>(d.kinematics.node.size())));
    trial_.x = s.x;
    trial_.time = s.time + dt;
    for (size_t k = 0; k < d.kinematics.node.size(); ++k) {
      trial_.x.col(d.kinematics.node[k]) = d.kinematics.target.col(static_cast<Eigen::Index>(k));
    }
    step_.setZero(3, n);
    renew_matrix();
    contacts_.begin(dt, s.x, trial_.x, inverse_mass_, d.contacts);
  }

  /// A new pattern, step, set of held nodes or of terms makes the matrix's kept parts stale.
  void renew_matrix() {
    if (pattern_ != dynamics_->pattern || matrix_.rows() != dynamics_->pattern->rows()) {
      pattern_ = dynamics_->pattern;
      matrix_ = *pattern_;
      stale_ = true;
      held_.clear();
      find_held_slots();
    }
    if (held_ != dynamics_->kinematics.node) {
      find_held_slots();
      stale_ = true;
    }
    if (prepared_dt_ != dt_ || prepared_energies_ != dynamics_->energies) stale_ = true;
  }

  void find_held_slots() {
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

  /// Chooses where Newton starts and returns the residual there. The explicit step repeats the last acceleration, since
  /// that was f(x0, v0) / m: for smooth motion it is off by the third derivative only.
  double start_iteration() {
    before_ = trial_.x;
    force_.setZero(3, start_->x.cols());
    for (const Energy* energy : dynamics_->energies) energy->add_force(*start_, &force_);
    step_ = dt_ * start_->v + force_ * (dt_ * dt_ * inverse_mass_).asDiagonal();
    for (int node : held_) step_.col(node).setZero();
    const double standing = std::sqrt(step_.squaredNorm() / free_) / (dt_ * dt_);
    if (!contacts_.empty()) {
      force_.setZero();
      contacts_.add_resting_force(&force_);
      step_ += force_ * (dt_ * dt_ * inverse_mass_).asDiagonal();
    }
    trial_.x = before_ + step_;
    evaluate();
    // Contacts are left out of the comparison: one Newton step puts them right from either start.
    if (!(unbalanced(base_) <= standing)) {
      trial_.x = before_;
      evaluate();
    }
    return unbalanced(residual_);
  }

  /// Residual at trial_.x: base_ without contacts, residual_ with them and zero at held nodes.
  void evaluate() {
    trial_.v = (trial_.x - start_->x) / dt_;
    force_.setZero(3, trial_.x.cols());
    for (const Energy* energy : dynamics_->energies) energy->add_force(trial_, &force_);
    base_ = (trial_.v - start_->v) * (*dynamics_->mass / dt_).asDiagonal() - force_;
    add_contacts();
  }

  void add_contacts() {
    residual_ = -base_;
    if (!contacts_.empty()) contacts_.add_force(trial_.x, &residual_);
    for (int node : held_) residual_.col(node).setZero();
  }

  /// Contacts not yet settled: stopping here would let points through or have friction drive them.
  bool is_rough(const StepReport& report) const {
    return !contacts_.empty() && (report.residual > kRough || contacts_.any_deeper(kDeep, trial_.x));
  }

  /// RMS of r / m over the free nodes, m/s^2.
  double unbalanced(const Nodes& residual) const {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < residual.cols(); ++i) {
      sum += residual.col(i).squaredNorm() * inverse_mass_[i] * inverse_mass_[i];
    }
    return std::sqrt(sum / free_);
  }

  void assemble(StepReport* report) {
    const double start = thread_cpu_time();
    matrix_.set_zero();
    for (int i = 0; i < matrix_.rows(); ++i) {
      matrix_.block(matrix_.diagonal_slot(i)).diagonal().setConstant((*dynamics_->mass)[i] / (dt_ * dt_));
    }
    for (const Energy* energy : dynamics_->energies) {
      energy->add_jacobian(trial_, 1.0, 1.0 / dt_, settings_.jacobian, &matrix_);
    }
    if (!contacts_.empty()) contacts_.add_jacobian(trial_.x, &matrix_);
    hold();
    report->seconds_assembly += thread_cpu_time() - start;
    if (!stale_) return;
    const double before = thread_cpu_time();
    solver_->prepare(matrix_);
    report->seconds_solve += thread_cpu_time() - before;
    prepared_dt_ = dt_;
    prepared_energies_ = dynamics_->energies;
    stale_ = false;
  }

  void hold() {
    for (int slot : held_slots_) matrix_.block(slot).setZero();
    for (int node : held_) matrix_.block(matrix_.diagonal_slot(node)).setIdentity();
  }

  /// step_ = A^-1 (-r). False when there is no solution to use.
  bool solve(StepReport* report) {
    const double start = thread_cpu_time();
    LinearTolerance tolerance;
    tolerance.relative = settings_.linear_tolerance;
    tolerance.iterations = settings_.linear_iterations;
    tolerance.absolute = kLinearShare * settings_.tolerance;
    step_.setZero();
    const LinearReport linear = solver_->solve(matrix_, residual_, inverse_mass_, tolerance, &step_);
    for (int node : held_) step_.col(node).setZero();
    report->linear_iterations += linear.iterations;
    report->seconds_solve += thread_cpu_time() - start;
    return step_.allFinite();
  }

  /// Moves trial_ along step_. No potential is needed, so drag and friction fit: the work p.r must not turn round by
  /// more than kEnough of what it was.
  void search_along_step() {
    const double slope = step_.cwiseProduct(residual_).sum();
    before_ = trial_.x;
    double fraction = 1.0;
    for (int k = 0; k <= kHalvings; ++k, fraction *= 0.5) {
      trial_.x = before_ + fraction * step_;
      evaluate();
      if (unbalanced(residual_) <= settings_.tolerance) return;
      const double ratio = step_.cwiseProduct(residual_).sum() / slope;
      if (!(ratio >= -kEnough && ratio <= kMostGrowth)) continue;
      if (std::abs(ratio) > kInexact)
        try_fraction(ratio < kLeastLeft ? fraction / (1.0 - ratio) : kFarthest * fraction);
      return;
    }
  }

  /// A slack sheet stiffens while it moves, so that full steps overshoot; a matrix stiffer than the forces falls short.
  /// The secant's zero of p.r is taken where it leaves a smaller residual.
  void try_fraction(double fraction) {
    const double full = unbalanced(residual_);
    other_ = trial_.x;
    trial_.x = before_ + fraction * step_;
    evaluate();
    if (unbalanced(residual_) < full) return;
    trial_.x = other_;
    evaluate();
  }

  void finish(Dynamics* d, State* s) {
    contacts_.report(trial_.x, &d->contacts);
    d->kinematics.reaction.resize(3, static_cast<Eigen::Index>(held_.size()));
    for (size_t k = 0; k < held_.size(); ++k) {
      d->kinematics.reaction.col(static_cast<Eigen::Index>(k)) = base_.col(held_[k]);
    }
    trial_.v = (trial_.x - s->x) / dt_;
    std::swap(trial_.x, s->x);
    std::swap(trial_.v, s->v);
    s->time += dt_;
  }

  SolverSettings settings_;
  std::unique_ptr<LinearSolver> solver_;
  PenaltyContacts contacts_;

  // The present step.
  double dt_ = 0.0;
  const Dynamics* dynamics_ = nullptr;
  const State* start_ = nullptr;
  State trial_;
  Nodes step_, before_, other_, force_;
  Nodes base_, residual_;         // base_ = M a - f; residual_ = contacts - base_, the direction to go
  Eigen::VectorXd inverse_mass_;  // 0 at held nodes
  double free_ = 1.0;             // number of free nodes

  // Kept from step to step.
  BlockMatrix matrix_;
  const BlockMatrix* pattern_ = nullptr;
  std::vector<int> held_, held_slots_;
  double prepared_dt_ = 0.0;
  std::vector<const Energy*> prepared_energies_;
  bool stale_ = true;
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_euler(const SolverSettings& settings) {
  return std::make_unique<ImplicitEuler>(settings);
}

}  // namespace deformable_sim
