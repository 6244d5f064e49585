// Tensions of springs as unknowns, solved line by line, in the formula of BDF2.
//
// With w = dt / dt_before:  v = (x - x_base) / tau,  a = (v - v_base) / tau,  tau = (1 + w) / (1 + 2 w) dt,
//   x_base = x0 + w^2 / (1 + 2 w) (x0 - x_before),   the same for v [Hairer 1993, III.5].
#include <limits>

#include "deformable_sim/core/integrator/schemes.h"
#include "dual_step.h"

namespace deformable_sim {
namespace {

constexpr double kMostGrowth = 2.0;  // of the step; beyond 1 + sqrt(2) the formula is unstable

template <class Real>
class LineDual : public Integrator {
 public:
  explicit LineDual(const SolverSettings& settings)
      : step_("line_dual", SpringChains::Grouping::kLines, settings.newton_iterations, settings.tolerance) {}

  std::string name() const override { return "line_dual"; }
  Needs needs() const override { return {false, true}; }
  int order() const override { return 2; }
  double stability_limit(double) const override { return std::numeric_limits<double>::infinity(); }
  void reset() override { step_.reset(); }

  StepReport advance(double dt, Dynamics* d, State* s) override {
    step_.prepare(*d);
    const bool known = s->x_before.cols() == s->x.cols() && s->dt_before > 0.0 && dt <= kMostGrowth * s->dt_before;
    const DualFormula formula = known ? two_step(dt, *s) : first_step(dt, *s);
    if (step_.has_local_forces()) extrapolate(dt, known, *s);
    const StepReport report = step_.advance(dt, formula, ahead_, d, s);
    std::swap(s->x_before, step_.start().x);
    std::swap(s->v_before, step_.start().v);
    s->dt_before = dt;
    forget_impacts(d->contacts, s);
    return report;
  }

 private:
  DualFormula two_step(double dt, const State& s) {
    const double w = dt / s.dt_before, more = w * w / (1.0 + 2.0 * w);
    x_base_ = s.x + more * (s.x - s.x_before);
    v_base_ = s.v + more * (s.v - s.v_before);
    const double tau = (1.0 + w) / (1.0 + 2.0 * w) * dt;
    return {tau, tau, &x_base_, &v_base_};
  }

  /// v+ = v + dt a(x+), x+ = x + dt (v + v+) / 2: of second order in x, for once, and exact in free fall.
  DualFormula first_step(double dt, const State& s) {
    x_base_ = s.x + 0.5 * dt * s.v;
    v_base_ = s.v;
    return {0.5 * dt, dt, &x_base_, &v_base_};
  }

  /// Where forces on single nodes are taken: the end of the step with the acceleration of the last one.
  void extrapolate(double dt, bool known, const State& s) {
    ahead_.copy_frames(s);
    ahead_.time = s.time + dt;
    ahead_.v = s.v;
    if (known) ahead_.v += (dt / s.dt_before) * (s.v - s.v_before);
    ahead_.x = s.x + 0.5 * dt * (s.v + ahead_.v);
  }

  /// As in BDF2: a node that was stopped gets a uniform motion for its past.
  static void forget_impacts(const ContactConstraints& contacts, State* s) {
    for (const ContactConstraint& c : contacts) {
      if (c.force.isZero(0.0)) continue;
      for (size_t k = 0; k < static_cast<size_t>(c.count); ++k) {
        s->x_before.col(c.node[k]) = s->x.col(c.node[k]) - s->dt_before * s->v.col(c.node[k]);
        s->v_before.col(c.node[k]) = s->v.col(c.node[k]);
      }
    }
  }

  DualStep<Real> step_;
  Nodes x_base_, v_base_;
  State ahead_;
};

}  // namespace

std::unique_ptr<Integrator> make_line_dual(const SolverSettings& settings) {
  if (settings.precision == SolverSettings::Precision::kSingle) return std::make_unique<LineDual<float>>(settings);
  return std::make_unique<LineDual<double>>(settings);
}

}  // namespace deformable_sim
