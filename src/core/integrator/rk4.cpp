// Classical Runge-Kutta.
#include "deformable_sim/core/integrator/explicit_step.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

class RungeKutta4 : public Integrator {
 public:
  std::string name() const override { return "rk4"; }
  Needs needs() const override { return {}; }
  int order() const override { return 4; }
  double stability_limit() const override { return 2.8284271247461903; }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.begin(dt, d, *s);
    stage_ = *s;
    stage(0.0, &dx1_, &dv1_);
    move(*s, 0.5 * dt, dx1_, dv1_);
    stage(0.5, &dx2_, &dv2_);
    move(*s, 0.5 * dt, dx2_, dv2_);
    stage(0.5, &dx3_, &dv3_);
    move(*s, dt, dx3_, dv3_);
    stage(1.0, &dx4_, &dv4_);
    s->x += (dt / 6.0) * (dx1_ + 2.0 * (dx2_ + dx3_) + dx4_);
    s->v += (dt / 6.0) * (dv1_ + 2.0 * (dv2_ + dv3_) + dv4_);
    return step_.finish(0.5, s);
  }

 private:
  void move(const State& start, double dt, const Nodes& dx, const Nodes& dv) {
    stage_.x = start.x + dt * dx;
    stage_.v = start.v + dt * dv;
    stage_.time = start.time + dt;
  }

  /// Slopes at stage_, a `fraction` into the step.
  void stage(double fraction, Nodes* dx, Nodes* dv) {
    step_.prescribe(fraction, &stage_);
    *dx = stage_.v;
    step_.acceleration(stage_, dv);
  }

  ExplicitStep step_;
  State stage_;
  Nodes dx1_, dx2_, dx3_, dx4_, dv1_, dv2_, dv3_, dv4_;
};

}  // namespace

std::unique_ptr<Integrator> make_rk4() {
  return std::make_unique<RungeKutta4>();
}

}  // namespace deformable_sim
