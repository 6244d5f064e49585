// The solution that the cells of the map are compared with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "deformable_sim/core/integrator/cpu_time.h"
#include "stability_run.h"

namespace deformable_sim::stability {
namespace {

constexpr double kOfLimit = 0.5;                                              // a step of rk4, of its limit
constexpr double kExplicitSteps = 4e5;                                        // beyond which it is left
constexpr double kOfTime = 1.0 / 200.0, kMostStep = 1e-3, kLeastStep = 5e-7;  // s, of tr_bdf2
constexpr double kTight = 1e-7;                                               // m/s^2
constexpr double kRounding = 2e-14;                                           // of omega^2 times the size
constexpr double kBetweenLooks = 200.0;                                       // steps, at the limit
constexpr double kSame = 1e-8;  // instants that differ by no more are one: no step is so short
constexpr int kCoarse = 1, kFine = 2;

/// rk4 where it is affordable, else tr_bdf2 as exactly as rounding allows.
struct Method {
  bool is_explicit = false;
  double limit = 0.0;  // s, of rk4
  std::unique_ptr<Integrator> scheme;

  double step_at(double time, int finer) const {
    if (is_explicit) return kOfLimit * limit / finer;
    return std::clamp(kOfTime * time, kLeastStep, kMostStep) / finer;
  }
  /// What is squeezed grows stiffer than it was at the start.
  void look_again(Plain* plain) {
    const double omega = highest_frequency(plain->dynamics(), plain->state, Effort::kRough);
    if (omega > 0.0) limit = std::min(limit, scheme->stability_limit() / omega);
  }
};

Method method_for(const Subject& subject, double seconds) {
  Method method;
  const Fastest fastest = fastest_of(subject);
  method.scheme = make_integrator("rk4", {});
  method.limit = std::min(stable_step(*method.scheme, fastest.omega, fastest.rate), 0.1);
  method.is_explicit = seconds / (kOfLimit * method.limit) < kExplicitSteps;
  if (method.is_explicit) return method;
  SolverSettings settings;
  const bool rope = subject.spec.bodies.size() == 1 && subject.spec.bodies[0].kind == BodyKind::kRope;
  settings.linear = rope ? SolverSettings::Linear::kBanded : SolverSettings::Linear::kDirect;
  settings.jacobian = rope ? Jacobian::kLagged : Jacobian::kProjected;
  settings.newton_iterations = 30;
  settings.tolerance = std::max(kTight, kRounding * fastest.omega * fastest.omega * subject.size);
  method.scheme = make_integrator("tr_bdf2", settings);
  return method;
}

}  // namespace

Reference::Reference(const Subject& subject, const std::vector<double>& dts, double most) {
  double last = 0.0;
  for (const double dt : dts) last = std::max(last, instant(dt, kQuarters));
  for (const double dt : dts) {
    for (int k = 1; k <= kQuarters; ++k) instants_[instant(dt, k)];
  }
  std::map<double, Instant> coarse = instants_;
  if (!solve(subject, kFine, 0.7 * most, &instants_)) method_ += ", not to the end";
  solve(subject, kCoarse, 0.3 * most, &coarse);
  const int points = subject.model->point_count();
  for (auto& [time, fine] : instants_) {
    const Nodes& x = coarse[time].x;
    if (x.cols() == 0 || fine.x.cols() == 0) fine.x.resize(3, 0);
    if (fine.x.cols() == 0) continue;
    fine.uncertain = std::sqrt((x - fine.x).leftCols(points).colwise().squaredNorm().mean());
    // Two solutions that both are far from any other, or that are not numbers, tell nothing.
    if (!std::isfinite(fine.uncertain)) fine.x.resize(3, 0);
  }
}

bool Reference::solve(const Subject& subject, int finer, double most, std::map<double, Instant>* solution) {
  Method method = method_for(subject, solution->rbegin()->first);
  method_ = method.scheme->name();
  Plain plain(subject, method.scheme->needs().jacobian);
  const Nodes start = plain.state.x;
  const int points = subject.model->point_count();
  const double began = thread_cpu_time();
  double time = 0.0;
  for (auto& [end, instant] : *solution) {
    while (time < end * (1.0 - kSame)) {
      // Steps lengthen as the time goes on, and end where they are asked to.
      const double left = end - time, wanted = method.step_at(time, finer);
      const double steps = std::max(1.0, std::ceil(left / wanted - 1e-9));
      const int count = static_cast<int>(std::min(steps, kBetweenLooks));
      for (int k = 0; k < count; ++k) plain.step(method.scheme.get(), left / steps);
      time = count == static_cast<int>(steps) ? end : time + count * left / steps;
      if (!plain.state.finite() || thread_cpu_time() - began > most) return false;
      if (method.is_explicit) method.look_again(&plain);
      furthest_ = std::max(furthest_, (plain.state.x - start).leftCols(points).cwiseAbs().maxCoeff());
    }
    instant.x = plain.state.x;
  }
  return true;
}

const Reference::Instant* Reference::at(double time) const {
  const auto found = instants_.find(time);
  return found == instants_.end() || found->second.x.cols() == 0 ? nullptr : &found->second;
}

}  // namespace deformable_sim::stability
