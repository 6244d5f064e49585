// Extended position-based dynamics: the tension of one spring after the other [Macklin 2016].
#include <limits>

#include "deformable_sim/core/integrator/schemes.h"
#include "dual_step.h"

namespace deformable_sim {
namespace {

template <class Real>
class Xpbd : public Integrator {
 public:
  explicit Xpbd(const SolverSettings& settings)
      : step_("xpbd", SpringChains::Grouping::kSingly, settings.newton_iterations, settings.tolerance) {}

  std::string name() const override { return "xpbd"; }
  Needs needs() const override { return {false, true}; }
  int order() const override { return 1; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { step_.reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.prepare(*d);
    return step_.advance(dt, {dt, dt, &s->x, &s->v}, *s, d, s);
  }

 private:
  DualStep<Real> step_;
};

}  // namespace

std::unique_ptr<Integrator> make_xpbd(const SolverSettings& settings) {
  if (settings.precision == SolverSettings::Precision::kSingle) return std::make_unique<Xpbd<float>>(settings);
  return std::make_unique<Xpbd<double>>(settings);
}

}  // namespace deformable_sim
