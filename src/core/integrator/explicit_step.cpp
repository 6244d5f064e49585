#include "deformable_sim/core/integrator/explicit_step.h"

namespace deformable_sim {

void ExplicitStep::begin(double dt, Dynamics* d, const State& s) {
  dt_ = dt;
  force_evaluations_ = 0;
  dynamics_ = d;
  const Kinematics& k = d->kinematics;
  const auto held = static_cast<Eigen::Index>(k.node.size());
  inverse_mass_ = d->mass->cwiseInverse();
  x0_.resize(3, held);
  v0_.resize(3, held);
  mean_force_.setZero(3, held);
  for (Eigen::Index i = 0; i < held; ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    inverse_mass_[node] = 0.0;
    x0_.col(i) = s.x.col(node);
    v0_.col(i) = s.v.col(node);
  }
  if (d->mass_matrix == nullptr) return;
  v_start_ = s.v;
  prescribed_inertia_.setZero(3, s.x.cols());
  add_prescribed_inertia(dt, *d->mass_matrix, k, s.x, s.v, &prescribed_inertia_);
  if (!mass_factor_) mass_factor_ = std::make_unique<MassFactor>();
  mass_factor_->prepare(*d->mass_matrix, k.node);
}

void ExplicitStep::acceleration(const State& s, double weight, Nodes* a) {
  force_.setZero(3, s.x.cols());
  for (const Energy* energy : dynamics_->energies) energy->add_force(s, &force_);
  ++force_evaluations_;
  if (dynamics_->mass_matrix != nullptr) {
    *a = force_ + prescribed_inertia_;
    mass_factor_->solve(a);
  } else {
    a->resize(3, s.x.cols());
    for (Eigen::Index i = 0; i < s.x.cols(); ++i) a->col(i) = inverse_mass_[i] * force_.col(i);
  }
  for (Eigen::Index i = 0; i < mean_force_.cols(); ++i) {
    mean_force_.col(i) += weight * force_.col(dynamics_->kinematics.node[static_cast<size_t>(i)]);
  }
}

void ExplicitStep::prescribe(double fraction, State* s) const {
  const Kinematics& k = dynamics_->kinematics;
  for (Eigen::Index i = 0; i < x0_.cols(); ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    const Vec3 path = k.target.col(i) - x0_.col(i);
    if (fraction == 1.0) {
      s->x.col(node) = k.target.col(i);
    } else {
      s->x.col(node) = x0_.col(i) + fraction * path;
    }
    s->v.col(node) = path / dt_;
  }
}

StepReport ExplicitStep::finish(double drift, State* s) {
  prescribe(1.0, s);
  if (!dynamics_->contacts.empty()) {
    contacts_.resolve(dynamics_->contacts, inverse_mass_, dt_, drift, s);
    for (size_t i = 0; i < dynamics_->contacts.size(); ++i) {
      dynamics_->contacts[i].force = contacts_.impulse(i, dynamics_->contacts) / dt_;
    }
  }
  find_reactions(*s);
  s->time += dt_;
  StepReport report;
  report.converged = s->finite();
  report.force_evaluations = force_evaluations_;
  return report;
}

/// m a - f with the means of a and f over the step.
void ExplicitStep::find_reactions(const State& s) {
  Kinematics& k = dynamics_->kinematics;
  k.reaction.resize(3, x0_.cols());
  for (Eigen::Index i = 0; i < x0_.cols(); ++i) {
    const int node = k.node[static_cast<size_t>(i)];
    if (dynamics_->mass_matrix == nullptr) {
      k.reaction.col(i) = (*dynamics_->mass)[node] / dt_ * (s.v.col(node) - v0_.col(i)) - mean_force_.col(i);
      continue;
    }
    k.reaction.col(i) = -mean_force_.col(i);
    for (Eigen::SparseMatrix<double>::InnerIterator it(*dynamics_->mass_matrix, node); it; ++it) {
      k.reaction.col(i) += it.value() / dt_ * (s.v.col(it.row()) - v_start_.col(it.row()));
    }
  }
}

}  // namespace deformable_sim
