// Second backward difference formula for variable steps.
//
// With w = dt / dt_before:  tau = (1 + w) / (1 + 2 w) dt,  v = (x - x_base) / tau,
//   x_base = x0 + w^2 / (1 + 2 w) (x0 - x_before),   the same for a and v [Hairer 1993, III.5].
#include <limits>

#include "deformable_sim/core/integrator/schemes.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

constexpr double kMostGrowth = 2.0;  // of the step; beyond 1 + sqrt(2) the formula is unstable

class Bdf2 : public Integrator {
 public:
  explicit Bdf2(const SolverSettings& settings) : needs_(stage_needs(settings)), stage_(make_stage_solver(settings)) {}

  std::string name() const override { return "bdf2"; }
  Needs needs() const override { return needs_; }
  int order() const override { return 2; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { stage_->reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    const bool known = s->x_before.cols() == s->x.cols() && s->dt_before > 0.0 && dt <= kMostGrowth * s->dt_before;
    const StepReport report = known ? two_step(dt, d, s) : first_step(dt, d, s);
    s->dt_before = dt;
    forget_impacts(d->contacts, s);
    return report;
  }

 private:
  /// Where a contact has changed the motion, the past is made up: a uniform motion. The real one would throw a node
  /// that was stopped, and whose contact is gone in the next step, back with more than the velocity it came with.
  static void forget_impacts(const ContactConstraints& contacts, State* s) {
    for (const ContactConstraint& c : contacts) {
      if (c.force.isZero(0.0)) continue;
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        s->x_before.col(c.node[k]) = s->x.col(c.node[k]) - s->dt_before * s->v.col(c.node[k]);
        s->v_before.col(c.node[k]) = s->v.col(c.node[k]);
      }
    }
  }

  StepReport first_step(double dt, Dynamics* d, State* s) {
    const Nodes x = s->x, v = s->v;
    const StepReport report = start_.advance(dt, stage_.get(), d, s);
    s->x_before = x;
    s->v_before = v;
    return report;
  }

  StepReport two_step(double dt, Dynamics* d, State* s) {
    const double w = dt / s->dt_before, more = w * w / (1.0 + 2.0 * w);
    x_base_ = s->x + more * (s->x - s->x_before);
    v_base_ = s->v + more * (s->v - s->v_before);
    StageEquation equation;
    equation.tau = (1.0 + w) / (1.0 + 2.0 * w) * dt;
    equation.x_base = &x_base_;
    equation.v_base = &v_base_;
    equation.duration = equation.contact_unit = dt;
    equation.force_wanted = false;
    const StepReport report = stage_->solve(equation, *s, *d);
    stage_->report_contacts(&d->contacts);
    take_reactions(stage_->outer_force(), &d->kinematics);
    s->x_before.swap(s->x);
    s->v_before.swap(s->v);
    s->x.swap(stage_->end().x);
    s->v.swap(stage_->end().v);
    s->time += dt;
    return report;  // not converged where anything is not finite
  }

  Needs needs_;
  std::unique_ptr<StageSolver> stage_;
  TrBdf2Step start_;
  Nodes x_base_, v_base_;
};

}  // namespace

std::unique_ptr<Integrator> make_bdf2(const SolverSettings& settings) {
  return std::make_unique<Bdf2>(settings);
}

}  // namespace deformable_sim
