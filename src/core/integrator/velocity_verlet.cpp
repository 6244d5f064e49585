// Velocity Verlet: kick, drift, kick.
#include <cmath>

#include "deformable_sim/core/integrator/explicit_step.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

class VelocityVerlet : public Integrator {
 public:
  std::string name() const override { return "velocity_verlet"; }
  Needs needs() const override { return {}; }
  int order() const override { return 2; }
  int order_with_velocity_forces() const override { return 1; }
  double stability_limit(double zeta) const override;

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.begin(dt, d, *s);
    step_.prescribe(0.0, s);
    step_.acceleration(*s, 0.5, &acceleration_);
    s->v += (0.5 * dt) * acceleration_;
    s->x += dt * s->v;
    step_.prescribe(1.0, s);
    s->time += dt;
    step_.acceleration(*s, 0.5, &acceleration_);
    s->time -= dt;
    s->v += (0.5 * dt) * acceleration_;
    return step_.finish(0.5, s);
  }

 private:
  ExplicitStep step_;
  Nodes acceleration_;
};

/// The step multiplies areas by (1 - zeta h)^2 and has the eigenvalue -1 where, with h in units of 1 / omega,
///   zeta h^3 + (4 zeta^2 - 2) h^2 - 8 zeta h + 8 = 0:
/// the first such h, or else 2 / zeta.
double VelocityVerlet::stability_limit(double zeta) const {
  if (zeta == 0.0) return 2.0;
  const double most = 2.0 / zeta;
  const auto margin = [zeta](double h) { return ((zeta * h + 4.0 * zeta * zeta - 2.0) * h - 8.0 * zeta) * h + 8.0; };
  const double b = 4.0 * zeta * zeta - 2.0;  // of the one minimum at positive h
  const double lowest = (-b + std::sqrt(b * b + 24.0 * zeta * zeta)) / (3.0 * zeta);
  if (lowest >= most || margin(lowest) > 0.0) return most;
  double below = 0.0, above = lowest;
  while (above - below > 1e-13) {
    const double middle = 0.5 * (above + below);
    (margin(middle) > 0.0 ? below : above) = middle;
  }
  return below;
}

}  // namespace

std::unique_ptr<Integrator> make_velocity_verlet() {
  return std::make_unique<VelocityVerlet>();
}

}  // namespace deformable_sim
