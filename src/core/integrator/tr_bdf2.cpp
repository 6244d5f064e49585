// TR-BDF2: trapezoidal rule to t + gamma dt, then the second backward difference to t + dt [Bank 1985].
//
//   v_g = v + gamma dt / 2 (a + a_g)          a = M^-1 f(x, v) at the start: enters as a force that remains
//   v_1 = c v_g - (c - 1) v + gamma dt / 2 a_1,   c = 1 / (gamma (2 - gamma)),   the same for x
//
// With gamma = 2 - sqrt(2) both stages have tau = gamma dt / 2, hence one matrix.
#include <cmath>
#include <limits>

#include "deformable_sim/core/integrator/mass_factor.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

const double kGamma = 2.0 - std::sqrt(2.0);
const double kPast = 1.0 / (kGamma * (2.0 - kGamma));  // c
// Weights of the forces at the start, the middle and the end.
const double kOuterWeight = 0.25 * std::sqrt(2.0);
const double kEndWeight = 0.5 * kGamma;

void add(const StepReport& part, StepReport* sum) {
  sum->converged = sum->converged && part.converged;
  sum->newton_iterations += part.newton_iterations;
  sum->linear_iterations += part.linear_iterations;
  sum->force_evaluations += part.force_evaluations;
  sum->residual = !(part.residual <= sum->residual) ? part.residual : sum->residual;  // keeps a NaN
  sum->seconds_assembly += part.seconds_assembly;
  sum->seconds_solve += part.seconds_solve;
}

class TrBdf2 : public Integrator {
 public:
  explicit TrBdf2(const SolverSettings& settings)
      : needs_(stage_needs(settings)), stage_(make_stage_solver(settings)) {}

  std::string name() const override { return "tr_bdf2"; }
  Needs needs() const override { return needs_; }
  int order() const override { return 2; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { stage_->reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override { return step_.advance(dt, stage_.get(), d, s); }

 private:
  Needs needs_;
  std::unique_ptr<StageSolver> stage_;
  TrBdf2Step step_;
};

}  // namespace

StepReport TrBdf2Step::advance(double dt, StageSolver* stage, Dynamics* d, State* s) {
  v_start_ = s->v;
  if (d->mass_matrix != nullptr) {
    prescribed_inertia_.setZero(3, s->x.cols());
    add_prescribed_inertia(dt, *d->mass_matrix, d->kinematics, s->x, s->v, &prescribed_inertia_);
  }
  take_up_speed(dt, d->kinematics, s);
  StepReport report = first_stage(dt, stage, d, s);
  add(second_stage(dt, stage, d, *s), &report);
  std::swap(s->x, stage->end().x);
  std::swap(s->v, stage->end().v);
  s->time += dt;
  if (stage->extrapolates()) remember(dt, *d, s);
  for (int node : d->kinematics.node) mean_force_.col(node) += kEndWeight * stage->force().col(node);
  average_reactions(dt, v_start_, s->v, mean_force_, d);
  report.converged = report.converged && s->finite();
  return report;
}

/// The acceleration that the last stage ends with, (v - v_base) / tau, is the next step's at its start.
void TrBdf2Step::remember(double dt, const Dynamics& d, State* s) const {
  s->dt_before = d.contacts.empty() ? dt : 0.0;
  if (d.contacts.empty()) s->v_before = s->v - (2.0 / kGamma) * (s->v - v_base_);
}

StepReport TrBdf2Step::first_stage(double dt, StageSolver* stage, Dynamics* d, State* s) {
  const double tau = 0.5 * kGamma * dt;
  x_base_ = s->x + tau * s->v;
  StageEquation equation;
  equation.tau = tau;
  equation.x_base = &x_base_;
  const bool known = stage->extrapolates() && d->contacts.empty() && s->x_before.cols() == 0 &&
                     s->v_before.cols() == s->v.cols() && s->dt_before > 0.0;
  if (known) {
    stage->find_held_force(*s, *d, &force_);
    v_base_ = s->v + (tau / s->dt_before) * (s->v - s->v_before);
    equation.v_base = &v_base_;
  } else {
    stage->find_force(*s, *d, &force_);
    equation.v_base = &s->v;
    equation.more_force = equation.start_force = &force_;
  }
  if (d->mass_matrix != nullptr) {
    remaining_force_ = force_ + 2.0 * prescribed_inertia_;  // the start's share and this stage's own
    equation.more_force = &remaining_force_;
  }
  equation.duration = kGamma * dt;
  equation.contact_unit = dt;
  equation.fraction = kGamma;
  equation.remaining = dt - equation.duration;
  StepReport report = stage->solve(equation, *s, *d);
  if (!known) ++report.force_evaluations;
  mean_force_.resize(3, s->x.cols());
  for (int node : d->kinematics.node) {
    mean_force_.col(node) = kOuterWeight * (force_.col(node) + stage->force().col(node));
  }
  if (!stage->extrapolates()) force_ = stage->force();
  stage->report_contacts(&d->contacts);
  contact_force_.clear();
  for (const ContactConstraint& c : d->contacts) contact_force_.push_back(kGamma * c.force);
  return report;
}

StepReport TrBdf2Step::second_stage(double dt, StageSolver* stage, Dynamics* d, const State& s) {
  std::swap(middle_.x, stage->end().x);
  std::swap(middle_.v, stage->end().v);
  middle_.time = stage->end().time;
  middle_.copy_frames(s);
  if (stage->extrapolates()) {
    middle_.v_before = s.v;
    middle_.dt_before = kGamma * dt;
  }
  x_base_ = middle_.x + (kPast - 1.0) * (middle_.x - s.x);
  v_base_ = middle_.v + (kPast - 1.0) * (middle_.v - s.v);
  StageEquation equation;
  equation.tau = 0.5 * kGamma * dt;
  equation.x_base = &x_base_;
  equation.v_base = &v_base_;
  if (!stage->extrapolates()) equation.start_force = &force_;
  if (d->mass_matrix != nullptr) equation.more_force = &prescribed_inertia_;
  equation.duration = (1.0 - kGamma) * dt;
  equation.contact_unit = dt;
  const StepReport report = stage->solve(equation, middle_, *d);
  stage->report_contacts(&d->contacts);
  for (size_t i = 0; i < d->contacts.size(); ++i) {
    d->contacts[i].force = contact_force_[i] + (1.0 - kGamma) * d->contacts[i].force;
  }
  return report;
}

std::unique_ptr<Integrator> make_tr_bdf2(const SolverSettings& settings) {
  return std::make_unique<TrBdf2>(settings);
}

}  // namespace deformable_sim
