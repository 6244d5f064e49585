#include "deformable_sim/core/strain_limit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "deformable_sim/core/error.h"

namespace deformable_sim {
namespace {

constexpr double kAccepted = 5e-7;  // relative violation that needs no projection
/// Stiffness of a limit within an implicit step, in effective masses over dt^2, beside that of the body. A tension T
/// that is no longer needed does the work T^2 / (2 k) before it is gone: less of it than damping takes keeps taut
/// threads from humming, more stiffness than this costs the linear solver its pace.
constexpr double kInertiaShare = 3000.0;

std::vector<LimitSprings::Element> elements_of(const std::vector<StrainLimit>& limits) {
  std::vector<LimitSprings::Element> elements;
  elements.reserve(limits.size());
  for (const StrainLimit& l : limits) elements.push_back({l.node[0], l.node[1], l.longest, 0.0, 0.0});
  return elements;
}

}  // namespace

std::vector<StrainLimit> strain_limits(const std::vector<SpringLink>& links, double limit, int first_node) {
  if (!(limit > 0.0) || !std::isfinite(limit))
    throw InputError("strain_limit is " + std::to_string(limit) + "; it must be finite and > 0 (relative elongation)");
  std::vector<StrainLimit> limits;
  limits.reserve(links.size());
  for (const SpringLink& l : links)
    limits.push_back({{l.a + first_node, l.b + first_node}, (1.0 + limit) * l.rest_length, l.stiffness});
  return limits;
}

StrainLimiter::StrainLimiter(const Model& model)
    : mass_(model.mass), springs_(elements_of(model.strain_limits)), projection_(model) {
  for (const StrainLimit& l : model.strain_limits) body_stiffness_.push_back(l.stiffness);
  impulse_.resize(body_stiffness_.size());
}

void StrainLimiter::find_inverse_mass(const Kinematics& kinematics) {
  inverse_mass_ = mass_.cwiseInverse();
  for (int node : kinematics.node) inverse_mass_[node] = 0.0;
}

/// The worst limit between nodes that are not both held, relative to its longest; at least 0.
double StrainLimiter::worst(const Nodes& x) const {
  double most = 0.0;
  for (const LimitSprings::Element& e : springs_.elements())
    if (inverse_mass_[e.a] + inverse_mass_[e.b] > 0.0)
      most = std::max(most, (x.col(e.b) - x.col(e.a)).norm() / e.longest - 1.0);
  return most;
}

double StrainLimiter::take_in(const Kinematics& kinematics, Nodes* x) {
  find_inverse_mass(kinematics);
  if (worst(*x) <= kAccepted) return 0.0;
  before_ = *x;
  projection_.solve(inverse_mass_, {}, x, &impulse_, &contact_impulse_);
  return (*x - before_).colwise().norm().maxCoeff();
}

void StrainLimiter::begin(double dt, const Kinematics& kinematics, State* s) {
  find_inverse_mass(kinematics);
  if (s->limit_tension.size() != count()) s->limit_tension.setZero(count());
  for (int k = 0; k < count(); ++k) {
    LimitSprings::Element& e = springs_.elements()[static_cast<size_t>(k)];
    const double compliance = inverse_mass_[e.a] + inverse_mass_[e.b];
    e.tension = s->limit_tension[k];
    e.stiffness =
        compliance > 0.0 ? body_stiffness_[static_cast<size_t>(k)] + kInertiaShare / (compliance * dt * dt) : 0.0;
  }
}

StrainLimitReport StrainLimiter::project(double dt, Dynamics* d, State* s) {
  const bool felt = d->pattern != nullptr;  // the scheme has solved with springs_
  StrainLimitReport report;
  report.violation = worst(s->x);
  const bool accepted = report.violation <= kAccepted;
  for (size_t k = 0; k < impulse_.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    s->limit_tension[at] = felt ? LimitSprings::tension(springs_.elements()[k], s->x) : 0.0;
  }
  if (accepted) return report;

  before_ = s->x;
  report = projection_.solve(inverse_mass_, d->contacts, &s->x, &impulse_, &contact_impulse_);
  s->v += (s->x - before_) / dt;
  for (size_t k = 0; k < impulse_.size(); ++k) {
    double& tension = s->limit_tension[static_cast<Eigen::Index>(k)];
    // Limits that cannot be met would pull harder with every step, and beyond all bounds.
    tension = report.converged ? tension + impulse_[k] / (dt * dt) : springs_.elements()[k].tension;
  }
  if (report.converged) add_forces(dt, d, *s);
  return report;
}

void StrainLimiter::add_forces(double dt, Dynamics* d, const State& s) {
  const double per_impulse = 1.0 / (dt * dt);
  for (size_t c = 0; c < contact_impulse_.size(); ++c)
    d->contacts[c].force += per_impulse * contact_impulse_[c] * d->contacts[c].normal;
  if (d->kinematics.node.empty()) return;

  held_force_.setZero(3, s.x.cols());
  for (size_t k = 0; k < impulse_.size(); ++k) {
    if (impulse_[k] == 0.0) continue;
    const LimitSprings::Element& e = springs_.elements()[k];
    const Vec3 force = per_impulse * impulse_[k] * (s.x.col(e.b) - s.x.col(e.a)).normalized();
    held_force_.col(e.a) += force;
    held_force_.col(e.b) -= force;
  }
  for (size_t i = 0; i < d->kinematics.node.size(); ++i)
    d->kinematics.reaction.col(static_cast<Eigen::Index>(i)) -= held_force_.col(d->kinematics.node[i]);
}

}  // namespace deformable_sim
