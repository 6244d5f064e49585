// Implicit Euler with one linearised solve a step.
#include <limits>

#include "deformable_sim/core/integrator/implicit_stage.h"
#include "deformable_sim/core/integrator/schemes.h"
#include "scheme_parts.h"

namespace deformable_sim {
namespace {

class LinearImplicitEuler : public Integrator {
 public:
  explicit LinearImplicitEuler(const SolverSettings& settings) : stage_(settings, ImplicitStage::Forces::kLinearised) {}

  std::string name() const override { return "linear_implicit_euler"; }
  Needs needs() const override { return {true}; }
  int order() const override { return 1; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { stage_.reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override { return implicit_euler_step(dt, &stage_, d, s); }

 private:
  ImplicitStage stage_;
};

}  // namespace

std::unique_ptr<Integrator> make_linear_implicit_euler(const SolverSettings& settings) {
  return std::make_unique<LinearImplicitEuler>(settings);
}

}  // namespace deformable_sim
