// Implicit (backward) Euler by Newton's method.
#include <limits>

#include "deformable_sim/core/integrator/schemes.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

class ImplicitEuler : public Integrator {
 public:
  explicit ImplicitEuler(const SolverSettings& settings)
      : needs_(stage_needs(settings)), stage_(make_stage_solver(settings)) {}

  std::string name() const override { return "implicit_euler"; }
  Needs needs() const override { return needs_; }
  int order() const override { return 1; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { stage_->reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override { return implicit_euler_step(dt, stage_.get(), d, s); }

 private:
  Needs needs_;
  std::unique_ptr<StageSolver> stage_;
};

}  // namespace

StepReport implicit_euler_step(double dt, StageSolver* stage, Dynamics* d, State* s) {
  StageEquation equation;
  equation.tau = equation.duration = equation.contact_unit = dt;
  equation.x_base = &s->x;
  equation.v_base = &s->v;
  StepReport report = stage->solve(equation, *s, *d);
  stage->report_contacts(&d->contacts);
  take_reactions(stage->outer_force(), &d->kinematics);
  std::swap(stage->end().x, s->x);
  std::swap(stage->end().v, s->v);
  s->time += dt;
  report.converged = report.converged && s->finite();
  return report;
}

std::unique_ptr<Integrator> make_implicit_euler(const SolverSettings& settings) {
  return std::make_unique<ImplicitEuler>(settings);
}

}  // namespace deformable_sim
