#include "deformable_sim/core/integrator/implicit_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deformable_sim/core/energy/limit_springs.h"
#include "deformable_sim/core/integrator/cpu_time.h"

namespace deformable_sim {
namespace {

constexpr double kEnough = 0.9;      // a step may turn p.r round by this much ...
constexpr double kMostGrowth = 1.5;  // ... or leave this much of it
constexpr double kInexact = 0.3;     // beyond this, the secant is tried
constexpr double kFarthest = 4.0;    // of a secant, in units of the Newton step
constexpr double kLeastLeft = 1.0 - 1.0 / kFarthest;
constexpr int kMostFullSteps = 10;      // two or three are enough when they are good at all
constexpr int kHalvings = 8;            // of a Newton step, at most
constexpr double kLinearShare = 0.3;    // of the Newton tolerance that the linear solve may leave
constexpr double kAtRest = 1e-3;        // of the tolerance: below, a step may take no Newton iteration at all
constexpr int kFrictionIterations = 5;  // Newton iterations in which friction follows the normal force
constexpr double kDeep = 3e-4;          // m: while a contact point is deeper ...
constexpr double kRough = 60.0;         // m/s^2: ... or the residual of a step with contacts larger, Newton goes on ...
constexpr int kRoughShare = 2;          // ... for at most so many times the allowed iterations

/// f += M a, columns are nodes.
void add_product(const Eigen::SparseMatrix<double>& mass, const Nodes& a, Nodes* f) {
  for (int j = 0; j < mass.outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator it(mass, j); it; ++it) f->col(it.row()) += it.value() * a.col(j);
  }
}

}  // namespace

void ImplicitStage::find_force(const State& s, const Dynamics& d, Nodes* f) {
  f->setZero(3, s.x.cols());
  for (const Energy* energy : d.energies) energy->add_force(s, f);
}

StepReport ImplicitStage::solve(const StageEquation& equation, const State& start, const Dynamics& d) {
  StepReport report;
  lap_ = thread_cpu_time();
  begin(equation, start, d);
  if (is_unresolved(tau_, start, d)) return solve_for_velocities();
  matrix_.renew(d, tau_);
  report.residual = full_steps_ ? start_full_steps() : start_iteration();
  report.seconds_assembly = lap();
  const double enough = settings_.tolerance;
  report.converged = report.residual <= kAtRest * enough;
  const int most = settings_.newton_iterations;
  for (int k = 0; k < most || (k < kRoughShare * most && is_rough(report)); ++k) {
    if (report.converged) break;
    if (full_steps_ && k == kMostFullSteps) report.residual = leave_full_steps();
    assemble();
    report.seconds_assembly += lap();
    const bool moves = solve_linear(&report);
    report.seconds_solve += lap();
    if (!moves) break;
    if (full_steps_) {
      take_full_step();
    } else {
      search_along_step();
    }
    if (!contacts_.empty() && k < kFrictionIterations) {
      contacts_.update_normal_forces(trial_.x);
      add_contacts();
    }
    ++report.newton_iterations;
    report.residual = full_steps_ ? left_over() : unbalanced(residual_);
    report.converged = report.residual <= enough;
    // What left_over() has found: a next step starts from the better for it, and holders feel less of what is left.
    if (full_steps_ && report.converged) take_full_step();
    report.seconds_assembly += lap();
  }
  if (!report.converged) contacts_.push_out(kDeep, inverse_mass_, &trial_.x);
  find_velocities();
  report.force_evaluations = force_evaluations_;
  return report;
}

/// Thread CPU time since it was last asked for, s.
double ImplicitStage::lap() {
  const double now = thread_cpu_time(), passed = now - lap_;
  lap_ = now;
  return passed;
}

void ImplicitStage::begin(const StageEquation& equation, const State& start, const Dynamics& d) {
  equation_ = equation;
  tau_ = equation.tau;
  force_evaluations_ = 0;
  dynamics_ = &d;
  start_ = &start;
  const Eigen::Index n = start.x.cols();
  inverse_mass_ = d.mass->cwiseInverse();
  for (int node : d.kinematics.node) inverse_mass_[node] = 0.0;
  free_ = static_cast<double>(std::max<Eigen::Index>(1, n - static_cast<Eigen::Index>(d.kinematics.node.size())));
  trial_.x = start.x;
  trial_.time = start.time + equation.duration;
  trial_.copy_frames(start);
  for (size_t k = 0; k < d.kinematics.node.size(); ++k) {
    const auto target = d.kinematics.target.col(static_cast<Eigen::Index>(k));
    auto x = trial_.x.col(d.kinematics.node[k]);
    if (equation.fraction == 1.0) {
      x = target;
    } else {
      x += equation.fraction * (target - x);
    }
  }
  step_.setZero(3, n);
  other_.resize(3, n);
  contacts_.begin(equation.contact_span(), start.x, trial_.x, inverse_mass_, d.contacts);
  full_steps_ = settings_.jacobian == Jacobian::kLagged && !linearised_ && d.contacts.empty();
  if (full_steps_) trial_.x_before = start.x;
  near_.clear();
  if (!d.contacts.empty() && equation.duration != tau_) find_near_nodes();
}

void ImplicitStage::find_near_nodes() {
  is_near_.assign(static_cast<size_t>(inverse_mass_.size()), 0);
  for (const ContactConstraint& c : dynamics_->contacts) {
    for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
      char& mark = is_near_[static_cast<size_t>(c.node[k])];
      if (mark != 0 || inverse_mass_[c.node[k]] == 0.0) continue;
      mark = 1;
      near_.push_back(c.node[k]);
    }
  }
}

/// Chooses where Newton starts and returns the residual there. The explicit step repeats the last acceleration, since
/// that was f(x0, v0) / m: for smooth motion it is off by the third derivative only.
double ImplicitStage::start_iteration() {
  if (coasts_) return coast();
  before_ = trial_.x;
  if (equation_.start_force != nullptr) {
    force_ = *equation_.start_force;
  } else {
    force_.setZero(3, start_->x.cols());
    for (const Energy* energy : dynamics_->energies) energy->add_force(*start_, &force_);
    ++force_evaluations_;
  }
  if (linearised_) linearise(settings_.jacobian == Jacobian::kAxial ? Jacobian::kAxial : Jacobian::kExact);
  guess();
  for (int node : matrix_.held()) step_.col(node).setZero();
  double moved = step_.squaredNorm();
  const double near_share = std::pow(tau_ / equation_.duration, 4);
  for (int node : near_) moved -= (1.0 - near_share) * step_.col(node).squaredNorm();
  const double standing = std::sqrt(moved / free_) / (tau_ * tau_);
  if (!contacts_.empty()) {
    force_.setZero();
    contacts_.add_resting_force(&force_);
    step_ += force_ * (equation_.duration * equation_.duration * inverse_mass_).asDiagonal();
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

/// As SheetSolve: from where every node would be with the velocity it has, or with strain limits, met at the start and
/// all but rigid, from the start if that has the smaller residual.
double ImplicitStage::coast() {
  before_ = trial_.x;
  step_ = equation_.duration * start_->v;
  for (int node : matrix_.held()) step_.col(node).setZero();
  trial_.x += step_;
  evaluate();
  const double moved = unbalanced(residual_);
  const auto limits = [](const Energy* energy) { return dynamic_cast<const LimitSprings*>(energy) != nullptr; };
  if (std::none_of(dynamics_->energies.begin(), dynamics_->energies.end(), limits)) return moved;
  std::swap(trial_.x, before_);
  evaluate();
  if (moved < unbalanced(residual_)) {
    std::swap(trial_.x, before_);
    evaluate();
  }
  return unbalanced(residual_);
}

/// Chooses where full Newton steps start: at the end of a motion with the last step's acceleration, or none where that
/// is not known. Forces at the start would do in theory; what a stiff rope's solution leaves of them would not.
double ImplicitStage::start_full_steps() {
  const State& s = *start_;
  before_ = trial_.x;
  step_ = tau_ * *equation_.v_base;
  if (equation_.x_base != &s.x) step_ += *equation_.x_base - s.x;
  if (s.v_before.cols() == s.v.cols() && s.dt_before > 0.0) {
    step_ += (tau_ * tau_ / s.dt_before) * (s.v - s.v_before);
  }
  for (int node : matrix_.held()) step_.col(node).setZero();
  trial_.x = before_ + step_;
  evaluate();
  return std::numeric_limits<double>::infinity();
}

/// Back to where this stage began: a slack chain has folds that whole steps throw to and fro.
double ImplicitStage::leave_full_steps() {
  full_steps_ = false;
  for (Eigen::Index i = 0; i < trial_.x.cols(); ++i) {
    if (inverse_mass_[i] > 0.0) trial_.x.col(i) = start_->x.col(i);
  }
  return start_iteration();
}

void ImplicitStage::take_full_step() {
  trial_.x += step_;
  evaluate();
}

/// RMS acceleration (m/s^2) that another Newton step with the last factors would add; without factors, the residual.
double ImplicitStage::left_over() {
  if (!matrix_.solve_again(residual_, &step_)) return unbalanced(residual_);
  return std::sqrt(step_.squaredNorm() / free_) / (tau_ * tau_);
}

/// step_: from the start to the explicit guess. In: force_ at the start.
void ImplicitStage::guess() {
  const double duration = equation_.duration;
  if (equation_.more_force != nullptr) {
    step_ = tau_ * *equation_.v_base + (force_ + *equation_.more_force) * (tau_ * tau_ * inverse_mass_).asDiagonal();
  } else {
    step_ = tau_ * *equation_.v_base + force_ * (tau_ * tau_ * inverse_mass_).asDiagonal();
  }
  if (equation_.x_base != &start_->x) step_ += *equation_.x_base - start_->x;
  for (int node : near_) {
    step_.col(node) = duration * start_->v.col(node) + (duration * duration * inverse_mass_[node]) * force_.col(node);
  }
}

void ImplicitStage::find_velocities() {
  trial_.v = (trial_.x - *equation_.x_base) / tau_;
  for (int node : near_) trial_.v.col(node) = (trial_.x.col(node) - start_->x.col(node)) / equation_.duration;
}

/// Residual at trial_.x: base_ without contacts, residual_ with them and zero at held nodes.
void ImplicitStage::evaluate() {
  find_velocities();
  if (linearised_) {
    work_ = trial_.x - *equation_.x_base - tau_ * *equation_.v_base;
    linear_.multiply(work_, &base_);
    base_ -= linear_force_;
    add_contacts();
    return;
  }
  force_.setZero(3, trial_.x.cols());
  for (const Energy* energy : dynamics_->energies) energy->add_force(trial_, &force_);
  ++force_evaluations_;
  if (dynamics_->mass_matrix != nullptr) {
    base_ = -force_;
    if (equation_.more_force != nullptr) base_ -= *equation_.more_force;
    for (int node : near_) base_.col(node) = -force_.col(node);
    add_inertia();
  } else {
    base_ = (trial_.v - *equation_.v_base) * (*dynamics_->mass / tau_).asDiagonal() - force_;
    if (equation_.more_force != nullptr) base_ -= *equation_.more_force;
    for (int node : near_) {
      base_.col(node) = ((*dynamics_->mass)[node] / equation_.duration) * (trial_.v.col(node) - start_->v.col(node)) -
                        force_.col(node);
    }
  }
  add_contacts();
}

/// base_ += M a, M the mass matrix.
void ImplicitStage::add_inertia() {
  work_ = (trial_.v - *equation_.v_base) / tau_;
  for (int node : near_) {
    work_.col(node) = (trial_.v.col(node) - start_->v.col(node)) / equation_.duration;
  }
  add_product(*dynamics_->mass_matrix, work_, &base_);
}

/// In: force_ = f(x0, v0). With x - x0 = tau v0 + y, v - v0 = y / tau the expansion gives
///   (M / tau^2 - K - C / tau) y = f0 + tau K v0     [Baraff 1998, eq. 6].
void ImplicitStage::linearise(Jacobian kind) {
  linear_kind_ = kind;
  BlockMatrix& a = matrix_.blocks();
  a.set_zero();
  matrix_.add_forces(*start_, 1.0, 0.0, kind);
  a.multiply(start_->v, &work_);
  linear_force_ = force_ - tau_ * work_;
  matrix_.set_inertia(near_, equation_.duration);
  matrix_.add_forces(*start_, 1.0, 1.0 / tau_, kind);
  linear_ = a;
  assembled_ = false;
}

void ImplicitStage::add_contacts() {
  residual_ = -base_;
  if (!contacts_.empty()) contacts_.add_force(trial_.x, &residual_);
  for (int node : matrix_.held()) residual_.col(node).setZero();
}

/// Contacts not yet settled: stopping here would let points through or have friction drive them.
bool ImplicitStage::is_rough(const StepReport& report) const {
  return !contacts_.empty() && (report.residual > kRough || contacts_.any_deeper(kDeep, trial_.x));
}

/// RMS of r / m over the free nodes, m/s^2.
double ImplicitStage::unbalanced(const Nodes& residual) const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < residual.cols(); ++i) {
    sum += residual.col(i).squaredNorm() * inverse_mass_[i] * inverse_mass_[i];
  }
  return std::sqrt(sum / free_);
}

void ImplicitStage::assemble() {
  if (linearised_ && assembled_ && contacts_.empty()) return;
  if (linearised_) {
    matrix_.blocks() = linear_;
    if (linear_kind_ == Jacobian::kExact) matrix_.make_symmetric();
    assembled_ = true;
  } else {
    matrix_.set_inertia(near_, equation_.duration);
    const bool lagged = settings_.jacobian == Jacobian::kLagged;
    matrix_.add_forces(trial_, 1.0, 1.0 / tau_, lagged && !full_steps_ ? Jacobian::kProjected : settings_.jacobian);
  }
  matrix_.couplings().clear();
  if (!contacts_.empty()) {
    contacts_.add_jacobian(trial_.x, inverse_mass_, &matrix_.blocks(), &matrix_.couplings());
  }
  matrix_.hold();
}

/// step_ = A^-1 (-r). False when there is no solution to use.
bool ImplicitStage::solve_linear(StepReport* report) {
  LinearTolerance tolerance;
  tolerance.relative = linearised_ ? 0.0 : settings_.linear_tolerance;
  tolerance.iterations = settings_.linear_iterations;
  tolerance.absolute = kLinearShare * settings_.tolerance;
  const LinearReport linear = matrix_.solve(residual_, inverse_mass_, tolerance, &step_, report);
  full_steps_ = full_steps_ && linear.kept;
  if (linearised_ && !linear.definite && linear_kind_ == Jacobian::kExact) {
    force_.setZero(3, trial_.x.cols());
    for (const Energy* energy : dynamics_->energies) energy->add_force(*start_, &force_);
    ++force_evaluations_;
    linearise(Jacobian::kProjected);
    evaluate();
    assemble();
    matrix_.solve(residual_, inverse_mass_, tolerance, &step_, report);
  }
  return step_.allFinite();
}

/// Moves trial_ along step_. No potential is needed, so drag and friction fit: the work p.r must not turn round by
/// more than kEnough of what it was.
void ImplicitStage::search_along_step() {
  const double slope = step_.cwiseProduct(residual_).sum();
  before_ = trial_.x;
  double fraction = 1.0, whole = 0.0;
  for (int k = 0; k <= kHalvings; ++k, fraction *= 0.5) {
    trial_.x = before_ + fraction * step_;
    evaluate();
    if (unbalanced(residual_) <= settings_.tolerance) return;
    const double work = step_.cwiseProduct(residual_).sum(), ratio = work / slope;
    if (k == 0) whole = work;
    if (!(ratio >= -kEnough && ratio <= kMostGrowth)) continue;
    if (std::abs(ratio) > kInexact) try_fraction(ratio < kLeastLeft ? fraction / (1.0 - ratio) : kFarthest * fraction);
    return;
  }
  // A step that solves nothing, as conjugate gradients in single precision return where k tau^2 / m is 1e8: of linear
  // forces the place along it is known where p.r is zero, and cannot be worse than where it began.
  if (!linearised_ || !contacts_.empty() || whole == slope) return;
  trial_.x = before_ + slope / (slope - whole) * step_;
  evaluate();
}

/// A slack sheet stiffens while it moves, so that full steps overshoot; a matrix stiffer than the forces falls short.
/// The secant's zero of p.r is taken where it leaves a smaller residual.
void ImplicitStage::try_fraction(double fraction) {
  const double full = unbalanced(residual_);
  other_ = trial_.x;
  trial_.x = before_ + fraction * step_;
  evaluate();
  if (unbalanced(residual_) < full) return;
  trial_.x = other_;
  evaluate();
}

}  // namespace deformable_sim
