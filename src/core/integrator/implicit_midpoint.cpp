// Implicit midpoint rule.
#include <limits>

#include "deformable_sim/core/integrator/implicit_stage.h"
#include "deformable_sim/core/integrator/mass_factor.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

class ImplicitMidpoint : public Integrator {
 public:
  explicit ImplicitMidpoint(const SolverSettings& settings) : stage_(settings) {}

  std::string name() const override { return "implicit_midpoint"; }
  Needs needs() const override { return {true}; }
  int order() const override { return 2; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { stage_.reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    // A point stopped at the middle of the step would be as far behind the plane at its end as it was before it at the
    // start.
    if (!d->contacts.empty()) return implicit_euler_step(dt, &stage_, d, s);
    StageEquation equation;
    equation.tau = equation.duration = 0.5 * dt;
    equation.fraction = 0.5;
    equation.x_base = &s->x;
    equation.v_base = &s->v;
    v_start_ = s->v;
    if (d->mass_matrix != nullptr) {
      prescribed_inertia_.setZero(3, s->x.cols());
      add_prescribed_inertia(dt, *d->mass_matrix, d->kinematics, s->x, s->v, &prescribed_inertia_);
      equation.more_force = &prescribed_inertia_;
    }
    take_up_speed(dt, d->kinematics, s);
    StepReport report = stage_.solve(equation, *s, *d);
    const State& middle = stage_.end();
    s->x = 2.0 * middle.x - s->x;
    s->v = 2.0 * middle.v - s->v;
    const Kinematics& k = d->kinematics;
    for (size_t i = 0; i < k.node.size(); ++i) {
      s->x.col(k.node[i]) = k.target.col(static_cast<Eigen::Index>(i));
      s->v.col(k.node[i]) = middle.v.col(k.node[i]);
    }
    average_reactions(dt, v_start_, s->v, stage_.force(), d);
    s->time += dt;
    report.converged = report.converged && s->finite();
    return report;
  }

 private:
  ImplicitStage stage_;
  Nodes v_start_;
  Nodes prescribed_inertia_;  // only with a mass matrix
};

}  // namespace

std::unique_ptr<Integrator> make_implicit_midpoint(const SolverSettings& settings) {
  return std::make_unique<ImplicitMidpoint>(settings);
}

}  // namespace deformable_sim
