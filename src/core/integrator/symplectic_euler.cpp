// Symplectic (semi-implicit) Euler.
#include <cmath>

#include "deformable_sim/core/integrator/explicit_step.h"
#include "deformable_sim/core/integrator/schemes.h"

namespace deformable_sim {
namespace {

class SymplecticEuler : public Integrator {
 public:
  std::string name() const override { return "symplectic_euler"; }
  Needs needs() const override { return {}; }
  int order() const override { return 1; }
  double stability_limit(double zeta) const override;

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.begin(dt, d, *s);
    step_.acceleration(*s, 1.0, &acceleration_);
    s->v += dt * acceleration_;
    s->x += dt * s->v;
    return step_.finish(1.0, s);
  }

 private:
  ExplicitStep step_;
  Nodes acceleration_;
};

/// h^2 + 4 zeta h = 4: an eigenvalue of the step reaches -1.
double SymplecticEuler::stability_limit(double zeta) const {
  return 2.0 / (std::sqrt(1.0 + zeta * zeta) + zeta);
}

}  // namespace

std::unique_ptr<Integrator> make_symplectic_euler() {
  return std::make_unique<SymplecticEuler>();
}

}  // namespace deformable_sim
