// Forward Euler.
#include <cmath>

#include "deformable_sim/core/integrator/explicit_step.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

class ExplicitEuler : public Integrator {
 public:
  std::string name() const override { return "explicit_euler"; }
  Needs needs() const override { return {}; }
  int order() const override { return 1; }
  double stability_limit(double zeta) const override;

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.begin(dt, d, *s);
    step_.acceleration(*s, 1.0, &acceleration_);
    s->x += dt * s->v;
    s->v += dt * acceleration_;
    return step_.finish(0.0, s);
  }

 private:
  ExplicitStep step_;
  Nodes acceleration_;
};

/// |1 + z| <= 1 at both z = h (-zeta +- sqrt(zeta^2 - 1)).
double ExplicitEuler::stability_limit(double zeta) const {
  return zeta <= 1.0 ? 2.0 * zeta : 2.0 / (zeta + std::sqrt(zeta * zeta - 1.0));
}

}  // namespace

std::unique_ptr<Integrator> make_explicit_euler() {
  return std::make_unique<ExplicitEuler>();
}

}  // namespace deformable_sim
