// Classical Runge-Kutta.
#include <algorithm>
#include <cmath>
#include <complex>

#include "deformable_sim/core/integrator/explicit_step.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

class RungeKutta4 : public Integrator {
 public:
  std::string name() const override { return "rk4"; }
  Needs needs() const override { return {}; }
  int order() const override { return 4; }
  double stability_limit(double zeta) const override;

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.begin(dt, d, *s);
    stage_ = *s;
    stage(0.0, 1.0 / 6.0, &dx1_, &dv1_);
    move(*s, 0.5 * dt, dx1_, dv1_);
    stage(0.5, 1.0 / 3.0, &dx2_, &dv2_);
    move(*s, 0.5 * dt, dx2_, dv2_);
    stage(0.5, 1.0 / 3.0, &dx3_, &dv3_);
    move(*s, dt, dx3_, dv3_);
    stage(1.0, 1.0 / 6.0, &dx4_, &dv4_);
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
  void stage(double fraction, double weight, Nodes* dx, Nodes* dv) {
    step_.prescribe(fraction, &stage_);
    *dx = stage_.v;
    step_.acceleration(stage_, weight, dv);
  }

  ExplicitStep step_;
  State stage_;
  Nodes dx1_, dx2_, dx3_, dx4_, dv1_, dv2_, dv3_, dv4_;
};

/// |1 + z + z^2/2 + z^3/6 + z^4/24| <= 1 at both z = h (-zeta +- sqrt(zeta^2 - 1)): the first h where it is not, by
/// bisection.
double RungeKutta4::stability_limit(double zeta) const {
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(zeta * zeta - 1.0, 0.0));
  const auto stable = [&](double h) {
    const auto factor = [](Complex z) {
      return std::abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))));
    };
    return std::max(factor(h * (-zeta + root)), factor(h * (-zeta - root))) <= 1.0 + 1e-12;
  };
  // The interval on the negative real axis is 2.785, on the imaginary one 2.828; none between is longer than 3.
  double above = 0.0, below = 0.0;
  const double reach = 3.0 / std::max(1.0, zeta), coarse = reach / 200.0;
  while (above <= reach && stable(above)) {
    below = above;
    above += coarse;
  }
  while (above - below > 1e-12 * above) {
    const double middle = 0.5 * (above + below);
    (stable(middle) ? below : above) = middle;
  }
  return below;
}

}  // namespace

std::unique_ptr<Integrator> make_rk4() {
  return std::make_unique<RungeKutta4>();
}

}  // namespace deformable_sim
